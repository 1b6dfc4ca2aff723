# Installs a build without simulation: none of it is shipped, and the example on a rig builds against the
# rest.
# cmake -DBUILD=... -DSOURCE=... -DCOMPILER=... -DWORK=... -P off.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/here)
file(GLOB_RECURSE shipped RELATIVE ${WORK}/here ${WORK}/here/include/* ${WORK}/here/lib*/* ${WORK}/here/share/pkgconfig/*)
list(FILTER shipped INCLUDE REGEX "/(sim|simulated|simulate)/|godobject[_-]sim")
if(shipped)
  message(FATAL_ERROR "of the simulation is shipped: ${shipped}")
endif()
run(${CMAKE_COMMAND} -S ${SOURCE}/docs/examples/rig -B ${WORK}/rig -DCMAKE_PREFIX_PATH=${WORK}/here
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${WORK}/rig)
