# Installs the build into a folder of its own, moves it elsewhere, and builds and runs the examples of docs/examples against
# it: cmake -DBUILD=... -DSOURCE=... -DWORK=... -P examples.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/there)
file(RENAME ${WORK}/there ${WORK}/here)  # wherever it is put
set(prefix ${WORK}/here)
foreach(example peg rig)
  run(${CMAKE_COMMAND} -S ${SOURCE}/docs/examples/${example} -B ${WORK}/${example} -DCMAKE_PREFIX_PATH=${prefix}
      -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=${COMPILER})
  run(${CMAKE_COMMAND} --build ${WORK}/${example})
endforeach()
run(${WORK}/peg/peg)
# Who links godobject::platform alone has no simulation.
run(${Python3_EXECUTABLE} ${SOURCE}/tests/install/links_no_simulation.py ${NM} ${prefix} ${WORK}/rig/peg_on_rig)
run(${Python3_EXECUTABLE} ${SOURCE}/tests/install/peg_on_rig.py ${prefix}/bin/godobject
    ${prefix}/share/godobject/scenes/rigid.toml ${WORK}/rig/peg_on_rig)
# The program finds its profiles and scenes where it is.
run(${prefix}/bin/godobject check ${prefix}/share/godobject/scenes/grasper.toml)
# pkg-config says the same as the package.
if(PKG_CONFIG)
  set(ENV{PKG_CONFIG_PATH} "")
  file(GLOB_RECURSE pc ${prefix}/*/godobject-core.pc)
  get_filename_component(folder ${pc} DIRECTORY)
  run(${CMAKE_COMMAND} -E env PKG_CONFIG_LIBDIR= PKG_CONFIG_PATH=${folder}:/usr/share/pkgconfig:/usr/lib/pkgconfig
      sh -c "${COMPILER} -std=c++20 $(${PKG_CONFIG} --cflags godobject-core) ${SOURCE}/docs/examples/peg/peg.cc -o ${WORK}/peg_pc && ${WORK}/peg_pc")
endif()
