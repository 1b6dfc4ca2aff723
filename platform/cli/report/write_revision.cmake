# Writes the source file of revision() if the revision has changed: cmake -DFOLDER=... -DFILE=... -P this.
# Changes of files that git does not track are not seen.
function(run_git result)
  execute_process(COMMAND git -C ${FOLDER} ${ARGN} OUTPUT_VARIABLE text ERROR_QUIET RESULT_VARIABLE failed
                  OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(failed)
    set(text "")
  endif()
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

set(revision unknown)
run_git(top rev-parse --show-toplevel)
file(REAL_PATH ${FOLDER} folder)
if(top STREQUAL folder)  # a tarball may lie below another project's repository
  run_git(revision rev-parse --short=12 HEAD)
  run_git(changes diff HEAD)
  if(changes)
    string(SHA1 hash "${changes}")
    string(SUBSTRING ${hash} 0 8 hash)
    string(APPEND revision "+${hash}")
  endif()
endif()
if(NOT revision)
  set(revision unknown)
endif()

set(text "// Written by write_revision.cmake.
#include \"platform/cli/report/revision.h\"

namespace godobject {

std::string_view revision() noexcept { return \"${revision}\"; }

}  // namespace godobject
")
set(before "")
if(EXISTS ${FILE})
  file(READ ${FILE} before)
endif()
if(NOT before STREQUAL text)
  file(WRITE ${FILE} "${text}")
endif()
