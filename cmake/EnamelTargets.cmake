# Compile options of all targets of this project, and the functions that make them.

# The implementation of lib/src/*/system_*.hpp, and what else differs between operating systems.
set(ENAMEL_SYSTEM posix)
if(WIN32)
  set(ENAMEL_SYSTEM windows)
  set(ENAMEL_SYSTEM_LIBRARIES ws2_32 avrt winmm)
endif()
set(ENAMEL_X86 OFF)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|amd64")
  set(ENAMEL_X86 ON)
endif()
# GCC for Windows aligns the stack to 16 bytes only, but spills AVX registers with aligned moves (bug 54412). The
# assembler can replace those moves. Unaligned moves of aligned data take the same time.
if(ENAMEL_X86 AND MINGW AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  include(CheckCXXCompilerFlag)
  set(ENAMEL_UNALIGNED_MOVES -Wa,-muse-unaligned-vector-move)
  check_cxx_compiler_flag(${ENAMEL_UNALIGNED_MOVES} ENAMEL_HAS_UNALIGNED_MOVES)
  if(NOT ENAMEL_HAS_UNALIGNED_MOVES)
    message(STATUS "The assembler is older than binutils 2.38: enamel is built without AVX")
    set(ENAMEL_X86 OFF)
  endif()
endif()

add_library(enamel_compile_options INTERFACE)
target_compile_features(enamel_compile_options INTERFACE cxx_std_17)
# Round every product and sum separately (no FMA contraction): all machines give the same bits.
target_compile_options(enamel_compile_options INTERFACE
  -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Wconversion
  -Wno-sign-conversion $<$<BOOL:${ENAMEL_WARNINGS_AS_ERRORS}>:-Werror>)
# GCC frees memory from 1 GB on, instead of a few MB: it compiles Eigen's templates in a sixth less time.
target_compile_options(enamel_compile_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1000000>)
if(WIN32)
  target_compile_definitions(enamel_compile_options INTERFACE NOMINMAX WIN32_LEAN_AND_MEAN _WIN32_WINNT=0x0A00
    _USE_MATH_DEFINES)
endif()
if(ENAMEL_SANITIZE)
  # Checks of every pointer double the compile time of Eigen's templates. The address sanitizer finds accesses through
  # bad pointers without them. A target with the property ENAMEL_PLAIN is not instrumented. It needs a property,
  # because its own options come before these.
  string(REPLACE "," "$<COMMA>" sanitizers "${ENAMEL_SANITIZE}")
  string(REPLACE "," "$<COMMA>" unchecked "null,alignment,object-size,pointer-overflow,vptr")
  target_compile_options(enamel_compile_options INTERFACE -fno-omit-frame-pointer
    "$<$<NOT:$<BOOL:$<TARGET_PROPERTY:ENAMEL_PLAIN>>>:-fsanitize=${sanitizers};-fno-sanitize-recover=all;-fno-sanitize=${unchecked}>")
  target_link_options(enamel_compile_options INTERFACE -fsanitize=${ENAMEL_SANITIZE})
endif()

option(ENAMEL_PRECOMPILED_HEADERS "Parse Eigen once for each kind of target instead of once a file" OFF)

# enamel_own_headers(<name> <header>...): add a target that parses the headers once. It needs the include folders and
# definitions of the targets that reuse them. enamel_reuse_headers(<target> <name>): let a target start from these
# headers. Only headers of pure templates save time: the code that a header instantiates itself (nlohmann-json, CLI11)
# is compiled in every file again. A build without precompiled headers and without joined files (the dev preset)
# checks that every file includes what it uses.
function(enamel_own_headers name)
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp CONTENT "")
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF)
  target_link_libraries(${name} PRIVATE enamel_compile_options)
  if(ENAMEL_PRECOMPILED_HEADERS)
    target_precompile_headers(${name} PRIVATE ${ARGN})
  endif()
endfunction()
function(enamel_reuse_headers target name)
  get_target_property(relocatable ${name} POSITION_INDEPENDENT_CODE)  # must be equal, or the headers do not fit
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ${relocatable})
  if(ENAMEL_PRECOMPILED_HEADERS)
    target_precompile_headers(${target} REUSE_FROM ${name})
  endif()
endfunction()

# enamel_add_module(<name> COMPONENT <component> SOURCES <files> [PUBLIC <targets>] [PRIVATE <targets>]): add the
# static library of a module in lib/. Its target is enamel::<name>. It is installed and exported with its component of
# the package.
function(enamel_add_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "COMPONENT" "SOURCES;PUBLIC;PRIVATE")
  set(target enamel_${name})
  add_library(${target} STATIC ${arg_SOURCES})
  add_library(enamel::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${target}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/lib/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${PROJECT_SOURCE_DIR}/lib/src)
  target_include_directories(${target} SYSTEM PRIVATE ${ENAMEL_TOMLPLUSPLUS})
  target_compile_features(${target} PUBLIC cxx_std_17)
  enamel_reuse_headers(${target} enamel_lib_headers)
  target_link_libraries(${target} PUBLIC ${arg_PUBLIC} PRIVATE $<BUILD_INTERFACE:enamel_compile_options> ${arg_PRIVATE})
  install(TARGETS ${target} EXPORT Enamel-${arg_COMPONENT} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
endfunction()
