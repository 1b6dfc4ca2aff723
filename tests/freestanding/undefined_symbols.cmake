# Lists the undefined symbols of an archive; all but plain memory copies are errors.
# cmake -DNM=nm -DARCHIVE=libx.a -P undefined_symbols.cmake
cmake_minimum_required(VERSION 3.25)
set(allowed memcpy memset memmove)

execute_process(COMMAND ${NM} --undefined-only --format=posix ${ARCHIVE}
                OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${NM} --defined-only --extern-only --format=posix ${ARCHIVE}
                OUTPUT_VARIABLE defined_listing COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+ [TtWwVvDdBbRr] " defined_lines "${defined_listing}")
list(LENGTH defined_lines num_defined)
if(num_defined EQUAL 0)
  message(FATAL_ERROR "${ARCHIVE} defines nothing: the check would be empty")
endif()

set(refused "")
string(REGEX MATCHALL "[^\n]+ [Uvw] " lines "${listing}")
foreach(line IN LISTS lines)
  string(REGEX REPLACE " .*" "" symbol "${line}")
  if(NOT symbol IN_LIST allowed)
    list(APPEND refused ${symbol})
  endif()
endforeach()
if(refused)
  list(REMOVE_DUPLICATES refused)
  list(JOIN refused " " refused)
  message(FATAL_ERROR "refused undefined symbols: ${refused}")
endif()
message(STATUS "${num_defined} functions, nothing undefined but (at most): ${allowed}")
