# `cpack` in a build folder makes Debian packages, one for each install component:
# - enamel-dev: to build programs;
# - enamel: the command-line tool, to push and compare;
# - enamel-viewer: the viewer;
# - enamel-doc: pages and examples;
# - enamel-data: devices, scenes, meshes and servos.
# The C++ libraries are static: a program keeps the version with which it was tested. The binary interfaces are those of
# plugins (enamel/plugin/abi.h) and of hosts (enamel/c/enamel.h, libenamel.so).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME enamel)
set(CPACK_PACKAGE_CONTACT "The authors of Enamel")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_LICENSE BSD-3-Clause)
set(CPACK_STRIP_FILES ON)

# enamel_package(<component> <description> [SHARED_LIBRARIES] [DEPENDS <packages>] [RECOMMENDS <packages>])
set(CPACK_COMPONENTS_ALL)
function(enamel_package component description)
  cmake_parse_arguments(PARSE_ARGV 2 arg "SHARED_LIBRARIES" "DEPENDS;RECOMMENDS" "")
  string(TOUPPER ${component} COMPONENT)
  foreach(pair "PACKAGE_NAME=${component}" "PACKAGE_DEPENDS=${arg_DEPENDS}" "PACKAGE_RECOMMENDS=${arg_RECOMMENDS}"
      "DESCRIPTION=${description}" "PACKAGE_SHLIBDEPS=${arg_SHARED_LIBRARIES}")
    string(REGEX MATCH "^([^=]*)=(.*)$" pair "${pair}")
    set(CPACK_DEBIAN_${COMPONENT}_${CMAKE_MATCH_1} "${CMAKE_MATCH_2}" PARENT_SCOPE)
  endforeach()
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
endfunction()
set(same "(= ${PROJECT_VERSION})")
enamel_package(enamel-data "Devices, scenes, meshes and servos of Enamel")
enamel_package(enamel-doc "Pages and examples of Enamel")
enamel_package(enamel-dev "Stiff contact on haptic devices: headers, static libraries, CMake and pkg-config files"
  DEPENDS "enamel-data ${same}, libeigen3-dev" RECOMMENDS "enamel-doc, libtbb-dev, libopenmesh-dev, libsimbody-dev")
if(ENAMEL_BUILD_APPS)
  enamel_package(enamel "Stiff contact on haptic devices: the tool and the plugins" SHARED_LIBRARIES
    DEPENDS "enamel-data ${same}")
  if(TARGET enamel-viewer)
    enamel_package(enamel-viewer "Stiff contact on haptic devices: the viewer" SHARED_LIBRARIES DEPENDS "enamel ${same}"
    RECOMMENDS "fonts-roboto-unhinted, libegl-mesa0, libgl1-mesa-dri")
  endif()
endif()
set(CPACK_DEBIAN_ENAMEL-DATA_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_ENAMEL-DOC_PACKAGE_ARCHITECTURE all)
include(CPack)

# pkg-config files for builds without CMake: one for each component, relocatable with its folder.
# enamel_pkg_config(<component> <libraries in the order of the linker> <required> <further flags of the linker>)
function(enamel_pkg_config component libraries requires flags)
  list(TRANSFORM libraries PREPEND -lenamel_)
  list(JOIN libraries " " libraries)
  file(RELATIVE_PATH root /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
  string(REGEX REPLACE "/$" "" root "${root}")
  file(CONFIGURE OUTPUT enamel-${component}.pc @ONLY CONTENT [[
prefix=${pcfiledir}/@root@
Name: enamel-@component@
Description: Stiff contact on haptic devices: @component@
Version: @PROJECT_VERSION@
Requires: @requires@
Cflags: -std=c++17 -DEIGEN_MAX_STATIC_ALIGN_BYTES=16 -I${prefix}/@CMAKE_INSTALL_INCLUDEDIR@
Libs: -L${prefix}/@CMAKE_INSTALL_LIBDIR@ @libraries@ @flags@
]])
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/enamel-${component}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
enamel_pkg_config(core "control;device;core" "eigen3" "")
enamel_pkg_config(collision "session;runtime;renderers;plugin;sim;render;collision" "enamel-core" "-pthread -ldl")
enamel_pkg_config(study "study" "enamel-collision, tbb" "")
