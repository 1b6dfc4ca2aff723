# Debian packages by CPack, of what is built: cpack --config CPackConfig.cmake in the build directory. Components of
# `cmake --install` are packages. Files that only packages have are left out of it when it is called without a component.
set(debian ${CMAKE_CURRENT_SOURCE_DIR}/debian)
set(GODOBJECT_CONTACT "godobject maintainers <maintainers@godobject.invalid>" CACHE STRING "maintainer of the packages")

set(CPACK_GENERATOR DEB)
set(CPACK_SET_DESTDIR ON)  # for the files in /etc
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_PACKAGE_VENDOR godobject)
set(CPACK_PACKAGE_CONTACT ${GODOBJECT_CONTACT})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SOURCE godobject)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_COMPONENTS_ALL "")

# godobject_package(COMPONENT PACKAGE SECTION SYNOPSIS DESCRIPTION [RELATION PACKAGES]...): RELATION is DEPENDS, RECOMMENDS or
# SUGGESTS. Scripts of the package are files `PACKAGE.*` of the folder debian.
macro(godobject_package component package section synopsis description)
  string(TOUPPER ${component} COMPONENT)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_SECTION ${section})
  set(CPACK_COMPONENT_${COMPONENT}_DESCRIPTION "${synopsis}\n${description}")
  cmake_parse_arguments(package "" "DEPENDS;RECOMMENDS;SUGGESTS" "" ${ARGN})
  foreach(relation DEPENDS RECOMMENDS SUGGESTS)
    set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_${relation} "${package_${relation}}")
  endforeach()
  file(GLOB scripts CONFIGURE_DEPENDS ${debian}/${package}.*)
  foreach(script IN LISTS scripts)
    get_filename_component(name ${script} EXT)
    string(SUBSTRING ${name} 1 -1 name)
    configure_file(${script} ${component}/${name} COPYONLY)
    list(APPEND CPACK_DEBIAN_${COMPONENT}_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/${component}/${name})
  endforeach()
  install(FILES ${debian}/copyright DESTINATION share/doc/${package} COMPONENT ${component} EXCLUDE_FROM_ALL)
  install(CODE "
    include(${debian}/documents.cmake)
    godobject_pack_changelog(${package} \"${PROJECT_SOURCE_DIR}\" ${PROJECT_VERSION} \"${GODOBJECT_CONTACT}\")"
    COMPONENT ${component} EXCLUDE_FROM_ALL)
endmacro()

godobject_package(program godobject science "physical simulation that a person's hand works in, by a haptic device"
  "A tool in a simulated scene is coupled to a tracked device by a damped
spring, in real time. The program runs scenes on CAN buses, serial trackers
or simulated devices, checks them, and evaluates their recordings. Profiles
of drives, example scenes, a systemd unit, udev rules and limits of a
real-time group belong to it."
  DEPENDS adduser SUGGESTS "godobject-doc, can-utils, gnuplot-nox, libhdf5-103-1")
# godobject::program links what the program links.
set(of_program "")
if(TINYXML2_LIBRARY)
  set(of_program ", libtinyxml2-dev")
endif()
godobject_package(dev libgodobject-dev libdevel "C++ libraries for haptic interaction with a physical simulation"
  "Headers, static libraries, a CMake package and pkg-config files of godobject's
real-time core, hardware layer, platform and simulated devices, with examples."
  DEPENDS "libeigen3-dev (>= 3.4)${of_program}" SUGGESTS "cmake, pkg-config, godobject-doc")
godobject_package(doc godobject-doc doc "documentation of godobject"
  "Tutorials, how-to pages, references, theory and pictures, in Markdown.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)

if(TARGET godobject_python)
  # The module is that of one version of Python: _core.cpython-311-x86_64-linux-gnu.so.
  get_target_property(suffix godobject_python SUFFIX)
  string(REGEX REPLACE "^\\.cpython-([0-9])([0-9]+)-.*" "\\1;\\2" python_version ${suffix})
  list(GET python_version 0 major)
  list(GET python_version 1 minor)
  math(EXPR next "${minor} + 1")
  godobject_package(python python3-godobject python "Python module of godobject"
    "Runs scenes step by step or as a whole, with results as NumPy arrays; reads
traces, recordings and reports; tests rigs with hardware in the loop."
    DEPENDS "python3 (>= ${major}.${minor}), python3 (<< ${major}.${next}), python3-numpy"
    RECOMMENDS "godobject (= ${PROJECT_VERSION})" SUGGESTS "python3-pytest, can-utils, godobject-doc")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
endif()

# A package must not be installed where its instructions are missing.
if(GODOBJECT_HOST_IS_X86_64_V3 AND GODOBJECT_MARCH STREQUAL "host" AND NOT GODOBJECT_DETERMINISTIC)
  foreach(component program python)
    string(TOUPPER ${component} COMPONENT)
    set(package ${CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME})
    configure_file(debian/preinst.in ${component}/preinst @ONLY FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
    list(APPEND CPACK_DEBIAN_${COMPONENT}_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/${component}/preinst)
  endforeach()
endif()

install(CODE "
  include(${debian}/documents.cmake)
  godobject_pack_texts($<TARGET_FILE:godobject>)" COMPONENT program EXCLUDE_FROM_ALL)
install(FILES debian/godobject@.service DESTINATION lib/systemd/system COMPONENT program EXCLUDE_FROM_ALL)
install(FILES debian/60-godobject.rules DESTINATION lib/udev/rules.d COMPONENT program EXCLUDE_FROM_ALL)
install(FILES debian/limits.conf DESTINATION /etc/security/limits.d RENAME godobject.conf COMPONENT program EXCLUDE_FROM_ALL)
install(DIRECTORY DESTINATION /etc/godobject COMPONENT program EXCLUDE_FROM_ALL)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/examples DESTINATION share/doc/libgodobject-dev COMPONENT dev EXCLUDE_FROM_ALL)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION share/doc/godobject-doc
        COMPONENT doc EXCLUDE_FROM_ALL)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION share/doc/godobject-doc COMPONENT doc EXCLUDE_FROM_ALL
        PATTERN examples EXCLUDE)
include(CPack)

# Builds the contents of the packages, and writes them to the folder `packages` of the build directory.
add_custom_target(packages
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${PROJECT_BINARY_DIR}/packages
  COMMAND ${CMAKE_CPACK_COMMAND} --config ${PROJECT_BINARY_DIR}/CPackConfig.cmake -B ${PROJECT_BINARY_DIR}/packages)
add_dependencies(packages godobject python_module)
foreach(library IN LISTS libraries)
  add_dependencies(packages godobject_${library})
endforeach()
