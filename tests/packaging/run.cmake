# Installs the build into a fresh prefix, then configures, builds and runs an outside project against it; plugins and hosts
# also across compilers, where Clang is installed.
file(REMOVE_RECURSE ${WORK_DIR})
set(prefix ${WORK_DIR}/prefix)
set(plugins ${prefix}/${LIBDIR}/enamel/plugins)
set(device ${prefix}/share/enamel/devices/tau-nominal.toml)
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# build_outside(<folder> <C compiler> <C++ compiler> <targets>...)
function(build_outside folder c cxx)
  run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/${folder} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_C_COMPILER=${c} -DCMAKE_CXX_COMPILER=${cxx} -DCMAKE_PREFIX_PATH=${prefix} -DHOST_SOURCE=${HOST_SOURCE})
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/${folder} --target ${ARGN})
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD_DIR} --config ${CONFIG} --prefix ${prefix})
build_outside(build ${C_COMPILER} ${CXX_COMPILER} consumer my_wall host)
run(${WORK_DIR}/build/consumer)
run(${prefix}/bin/enamel plugins)
run(${prefix}/bin/enamel check-plugin ${WORK_DIR}/build/my_wall.so)
run(${WORK_DIR}/build/host ${plugins}/enamel_impedance.so ${device})

find_program(CLANG clang)
find_program(CLANGXX clang++)
if(CLANG AND CLANGXX)
  build_outside(clang ${CLANG} ${CLANGXX} my_wall host)
  run(${prefix}/bin/enamel check-plugin ${WORK_DIR}/clang/my_wall.so)
  run(${WORK_DIR}/clang/host ${plugins}/enamel_impedance.so ${device})
else()
  message(STATUS "Clang is not installed: plugins and hosts of two compilers are not tried")
endif()
