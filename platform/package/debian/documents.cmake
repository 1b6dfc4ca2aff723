# Documents of a package that are made when it is packed. The install scripts of debian.cmake read this file.

# godobject_output_of(FILE COMMAND...): writes the output of a command to a file.
function(godobject_output_of file)
  get_filename_component(folder ${file} DIRECTORY)
  file(MAKE_DIRECTORY ${folder})
  execute_process(COMMAND ${ARGN} OUTPUT_FILE ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# godobject_pack_changelog(PACKAGE SOURCE VERSION CONTACT): the changelog in Debian's form. Its date is that of the last release.
function(godobject_pack_changelog package source version contact)
  set(changelog $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/doc/${package}/changelog)
  file(STRINGS ${source}/CHANGELOG.md released REGEX "^## \\[[0-9.]+\\] - ")
  list(GET released 0 latest)
  string(REGEX REPLACE ".* - " "" date ${latest})
  execute_process(COMMAND date -u -R -d ${date} OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  file(WRITE ${changelog} "godobject (${version}) bookworm; urgency=medium

  * Changes are listed in /usr/share/doc/godobject-doc/CHANGELOG.md.

 -- ${contact}  ${date}
")
  execute_process(COMMAND gzip -9nf ${changelog} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# godobject_pack_texts(PROGRAM): manual pages and completion, written by the program.
function(godobject_pack_texts program)
  set(share $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share)
  godobject_output_of(${share}/bash-completion/completions/godobject ${program} completion bash)
  set(pages ${share}/man/man1)
  godobject_output_of(${pages}/godobject.1 ${program} man)
  file(STRINGS ${pages}/godobject.1 verbs REGEX "^\\.SS [^ ]+$")
  foreach(verb IN LISTS verbs)
    string(REGEX REPLACE "^\\.SS |\\\\" "" verb ${verb})
    godobject_output_of(${pages}/godobject-${verb}.1 ${program} man ${verb})
  endforeach()
  file(GLOB pages ${pages}/*.1)
  execute_process(COMMAND gzip -9nf ${pages} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
