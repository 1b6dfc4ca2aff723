# The package godobject of this tree, core and SLCAN: examples are built against it without an installation.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
add_library(godobject::core INTERFACE IMPORTED)
target_include_directories(godobject::core INTERFACE ${CMAKE_CURRENT_LIST_DIR}/../../..)
target_compile_features(godobject::core INTERFACE cxx_std_20)
target_compile_definitions(godobject::core INTERFACE EIGEN_DONT_VECTORIZE)
target_link_libraries(godobject::core INTERFACE Eigen3::Eigen)
# Compiled into the program that links it, by the program's compiler.
add_library(godobject::slcan INTERFACE IMPORTED)
target_sources(godobject::slcan INTERFACE ${CMAKE_CURRENT_LIST_DIR}/../../../hal/can/slcan.cc)
target_link_libraries(godobject::slcan INTERFACE godobject::core)
