# Installs the build into a folder of its own, moves it elsewhere, and builds and runs the examples of
# docs/examples against it:
# cmake -DBUILD=... -DSOURCE=... -DWORK=... -P examples.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/there)
file(RENAME ${WORK}/there ${WORK}/here)  # must work at any place
set(prefix ${WORK}/here)
file(GLOB_RECURSE of_packages ${prefix}/lib/systemd/* ${prefix}/lib/udev/* ${prefix}/share/doc/* ${prefix}/share/man/*)
if(of_packages)
  message(FATAL_ERROR "files that only Debian packages have are installed: ${of_packages}")
endif()
foreach(example peg rig program)
  run(${CMAKE_COMMAND} -S ${SOURCE}/docs/examples/${example} -B ${WORK}/${example} -DCMAKE_PREFIX_PATH=${prefix}
      -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=${COMPILER})
  run(${CMAKE_COMMAND} --build ${WORK}/${example})
endforeach()
run(${WORK}/peg/peg)
# A program of one's own has the verbs of `godobject`, and its replays are compared with its own step.
set(of_run --fast --quiet --duration 2 --bus sim)
run(${WORK}/program/guided run ${prefix}/share/godobject/scenes/rigid.toml ${of_run} --trace ${WORK}/guided.csv
    --record ${WORK}/guided.godo)
run(${WORK}/program/guided replay ${WORK}/guided.godo)
run(${prefix}/bin/godobject run ${prefix}/share/godobject/scenes/rigid.toml ${of_run} --trace ${WORK}/plain.csv)
file(SHA256 ${WORK}/guided.csv guided)
file(SHA256 ${WORK}/plain.csv plain)
if(guided STREQUAL plain)
  message(FATAL_ERROR "the law of the program guided is not in its trace")
endif()
run(${Python3_EXECUTABLE} ${SOURCE}/tests/install/own_program.py ${WORK}/program/guided ${SOURCE}/docs/examples/program ${WORK}/own)
# Programs that link only godobject::platform contain no simulation.
run(${Python3_EXECUTABLE} ${SOURCE}/tests/install/links_no_simulation.py ${NM} ${prefix} ${WORK}/rig/peg_on_rig)
run(${Python3_EXECUTABLE} ${SOURCE}/tests/install/peg_on_rig.py ${prefix}/bin/godobject
    ${prefix}/share/godobject/scenes/rigid.toml ${WORK}/rig/peg_on_rig)
# The program finds its profiles and scenes beside itself.
run(${prefix}/bin/godobject check ${prefix}/share/godobject/scenes/grasper.toml)
# The Python modules, from the prefix alone.
run(${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/lib/python3/dist-packages ${Python3_EXECUTABLE}
    ${SOURCE}/tests/install/hil_from_prefix.py ${prefix} ${SOURCE}/tests/hil/rig.toml)
if(MODULE_PYTHON)
  run(${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/lib/python3/dist-packages ${MODULE_PYTHON} -c
      "import godobject._core as core; from godobject import Scene; assert core.__file__.startswith('${prefix}'); Scene('${prefix}/share/godobject/scenes/wall.toml').step(10)")
endif()
# Tests of a newcomer by the installed pytest plugin alone: two of eight, all where GODOBJECT_NIGHTLY is set (./dev nightly).
set(has_no_pytest 1)
if(MODULE_PYTHON)
  execute_process(COMMAND ${MODULE_PYTHON} -c "import pytest" RESULT_VARIABLE has_no_pytest ERROR_QUIET)
endif()
if(has_no_pytest EQUAL 0)
  set(which -k "unplug or watchdog")
  if(DEFINED ENV{GODOBJECT_NIGHTLY})
    set(which "")
  endif()
  run(${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/lib/python3/dist-packages PYTHONDONTWRITEBYTECODE=1 ${MODULE_PYTHON} -m pytest
      -q -p no:cacheprovider -p godobject.hil.pytest_plugin --noconftest --program ${prefix}/bin/godobject
      ${SOURCE}/tests/hil/test_strangers.py ${which})
endif()
# pkg-config gives the same flags as the package.
if(PKG_CONFIG)
  set(ENV{PKG_CONFIG_PATH} "")
  file(GLOB_RECURSE pc ${prefix}/*/godobject-core.pc)
  get_filename_component(folder ${pc} DIRECTORY)
  foreach(example "core peg peg" "platform rig peg_on_rig")
    separate_arguments(example)
    list(GET example 0 library)
    list(GET example 1 folder_of_example)
    list(GET example 2 name)
    run(${CMAKE_COMMAND} -E env PKG_CONFIG_LIBDIR= PKG_CONFIG_PATH=${folder}:/usr/share/pkgconfig:/usr/lib/pkgconfig
        sh -c "${COMPILER} -std=c++20 $(${PKG_CONFIG} --cflags godobject-${library}) ${SOURCE}/docs/examples/${folder_of_example}/${name}.cc -o ${WORK}/${name}_pc $(${PKG_CONFIG} --libs godobject-${library})")
  endforeach()
  run(${WORK}/peg_pc)
endif()
