# Unpacks the build's packages into a new prefix (without dpkg: installs there). Then configures, builds and runs an
# outside project against it. Plugins and hosts are also combined across compilers if Clang is installed.
file(REMOVE_RECURSE ${WORK_DIR})
set(prefix ${WORK_DIR}/prefix)
set(plugins ${prefix}/${LIBDIR}/enamel/plugins)
set(device ${prefix}/share/enamel/devices/cartesian-3.toml)
set(tau ${prefix}/share/enamel/devices/tau-nominal.toml)
set(examples ${prefix}/share/doc/enamel/apps/examples)
set(quick "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG")  # compiles faster than -O3
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# build_outside(<folder> <C compiler> <C++ compiler> <targets>...)
function(build_outside folder c cxx)
  run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/${folder} -DCMAKE_BUILD_TYPE=Release ${quick}
    -DCMAKE_C_COMPILER=${c} -DCMAKE_CXX_COMPILER=${cxx} -DCMAKE_PREFIX_PATH=${prefix} -DEXAMPLES=${examples} -DREADME_PAGE=${prefix}/share/doc/enamel/README.md ${options})
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/${folder} --target ${ARGN})
endfunction()

find_program(DPKG_DEB dpkg-deb)
find_program(SHLIBDEPS dpkg-shlibdeps)
if(DPKG_DEB AND SHLIBDEPS)
  run(${CMAKE_CPACK_COMMAND} --config ${BUILD_DIR}/CPackConfig.cmake -C ${CONFIG} -B ${WORK_DIR}/packages
    -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip)
  file(GLOB packages ${WORK_DIR}/packages/*.deb)
  foreach(package ${packages})
    run(${DPKG_DEB} -x ${package} ${WORK_DIR}/root)
    execute_process(COMMAND ${DPKG_DEB} -f ${package} Package Depends COMMAND_ECHO NONE)
  endforeach()
  file(RENAME ${WORK_DIR}/root/usr ${prefix})
else()
  message(STATUS "dpkg-dev is not installed: no packages are made")
  run(${CMAKE_COMMAND} --install ${BUILD_DIR} --config ${CONFIG} --prefix ${prefix})
endif()
set(options -DCORE_ONLY=ON)
build_outside(core ${C_COMPILER} ${CXX_COMPILER} core)
run(${WORK_DIR}/core/core)
set(options -DCMAKE_DISABLE_FIND_PACKAGE_OpenMesh=ON)  # only needed for openmesh.hpp
build_outside(build ${C_COMPILER} ${CXX_COMPILER} consumer readme my_wall smooth_wall host)
run(${WORK_DIR}/build/consumer)
execute_process(COMMAND ${WORK_DIR}/build/readme WORKING_DIRECTORY ${SOURCE_DIR} COMMAND_ERROR_IS_FATAL ANY)
run(${prefix}/bin/enamel plugins)
run(${prefix}/bin/enamel check-plugin ${WORK_DIR}/build/my_wall.so)
run(${prefix}/bin/enamel check-plugin ${WORK_DIR}/build/smooth_wall.so)
run(${prefix}/bin/enamel push --device ${tau} --renderer ${WORK_DIR}/build/smooth_wall.so --device-damping 4)
foreach(plugin enamel_impedance.so enamel_position_control.so)
  run(${WORK_DIR}/build/host ${plugins}/${plugin} ${device})
endforeach()
run(${WORK_DIR}/build/host ${WORK_DIR}/build/my_wall.so ${device})

# Build without CMake.
find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  set(ENV{PKG_CONFIG_PATH} ${prefix}/${LIBDIR}/pkgconfig)
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs enamel-collision OUTPUT_VARIABLE flags
    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  run(${CXX_COMPILER} -DENAMEL_DATA_DIR="${prefix}/share/enamel" ${CMAKE_CURRENT_LIST_DIR}/consumer.cpp ${flags}
    -o ${WORK_DIR}/by_pkg_config)
  run(${WORK_DIR}/by_pkg_config)
  if(DEFINED ENV{ENAMEL_LONG})
    run(${CXX_COMPILER} -I${SOURCE_DIR}/tests/chai3d ${prefix}/share/doc/enamel/plugins/chai3d/example.cpp ${flags}
      -o ${WORK_DIR}/chai3d_wall)
    run(${WORK_DIR}/chai3d_wall)
  endif()
  run(${PKG_CONFIG} --exists --print-errors enamel-study)
else()
  message(STATUS "pkg-config is not installed: its files are not tried")
endif()

# Build one of the examples as a separate project; all of them are built with the library.
run(${CMAKE_COMMAND} -S ${examples} -B ${WORK_DIR}/examples -DCMAKE_BUILD_TYPE=Release ${quick} -DCMAKE_C_COMPILER=${C_COMPILER}
  -DCMAKE_CXX_COMPILER=${CXX_COMPILER} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/examples --target own_tooth)
run(${WORK_DIR}/examples/own_tooth ${prefix}/share/enamel/meshes/molar.ply)

find_program(CLANG clang)
find_program(CLANGXX clang++)
if(CLANG AND CLANGXX)
  build_outside(clang ${CLANG} ${CLANGXX} my_wall host)
  run(${prefix}/bin/enamel check-plugin ${WORK_DIR}/clang/my_wall.so)
  run(${WORK_DIR}/clang/host ${plugins}/enamel_impedance.so ${device})
else()
  message(STATUS "Clang is not installed: plugins and hosts of two compilers are not tried")
endif()
