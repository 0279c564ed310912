# SPDX-License-Identifier: MIT
# selvedge_library(NAME [FOLDER [EXCEPT ...]] [SOURCES ...] HEADERS ... DEPENDS ... PRIVATE ...) makes the library
# selvedge_NAME, alias selvedge::NAME. With FOLDER it takes all sources of its folder and of detail/, except those that
# match EXCEPT. A library with the name of its folder installs all headers of the folder; any other library installs those
# in HEADERS. In the build tree, include/selvedge links to the source root, so that <selvedge/core/base/types.h> reads
# the same in-tree and installed.
set(SELVEDGE_INCLUDE_DIR ${PROJECT_BINARY_DIR}/include)
file(MAKE_DIRECTORY ${SELVEDGE_INCLUDE_DIR})
file(CREATE_LINK ${PROJECT_SOURCE_DIR} ${SELVEDGE_INCLUDE_DIR}/selvedge SYMBOLIC)

if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
# The compiler cache needs this setting to handle precompiled headers.
find_program(SELVEDGE_CCACHE ccache)
if(SELVEDGE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${SELVEDGE_CCACHE})
  if(SELVEDGE_PCH)
    add_compile_options($<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  endif()
endif()
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME development)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
list(PREPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})  # FindOSMesa

# selvedge_uses(NAME VERSION LICENCE) records a library that this build links, for `selvedge --version`.
function(selvedge_uses name version licence)
  get_property(known GLOBAL PROPERTY SELVEDGE_LIBRARIES)
  set(entry "${name} ${version} (${licence})")
  if(NOT entry IN_LIST known)
    set_property(GLOBAL APPEND PROPERTY SELVEDGE_LIBRARIES "${entry}")
  endif()
endfunction()
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
selvedge_uses(Eigen "${Eigen3_VERSION}" MPL-2.0)

# Warnings, and the floating-point rules that determinism needs, for our own targets only. g++ 12 reports -Wrestrict,
# -Warray-bounds and -Wstringop-overflow inside its own std::string (GCC bugs 105651 and 105329), which must not break
# CI. Below a heap of a gigabyte (kB here) g++ collects garbage several times per batch, a tenth of the compile time, and
# frees little. A compiler process takes up to 1.8 GB.
function(selvedge_target_defaults target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1048576>)
  # The comparisons of boxes join booleans by & on purpose: one branch instead of six.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:Clang>:-Wno-bitwise-instead-of-logical>)
  # On 64-bit Arm, Eigen multiplies and adds in one rounding where this macro is defined, and -ffp-contract does not reach
  # its intrinsics.
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
    target_compile_options(${target} PRIVATE -U__ARM_FEATURE_FMA)
  endif()
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -ffp-contract=off
                         "$<$<BOOL:${SELVEDGE_WERROR}>:-Werror;-Wno-error=restrict;-Wno-error=array-bounds;-Wno-error=stringop-overflow>")
endfunction()

# selvedge_unite(TARGET) compiles the sources of the target in batches, each as one file. A whole build then takes half
# the processor time, because a batch reads our headers once. Batches are equal and hold at most 32 sources. Names in
# unnamed namespaces must differ within a target. selvedge_unite(TARGET BATCHES) is for a target that is compiled last, when
# other processors would wait for its only batch.
function(selvedge_unite target)
  get_target_property(sources ${target} SOURCES)
  list(LENGTH sources count)
  set(batches ${ARGV1})
  if(ARGC EQUAL 1)
    math(EXPR batches "(${count} + 31) / 32")
  endif()
  math(EXPR size "(${count} + ${batches} - 1) / ${batches}")
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${SELVEDGE_UNITY} UNITY_BUILD_BATCH_SIZE ${size})
  # A batch is not a source file to g++, so it warns of classes that hold types of an unnamed namespace.
  if(SELVEDGE_UNITY)
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# selvedge_optimize_less(TARGET [LEVEL]): for tests and benchmarks (level 1), and for code that reads and writes JSON and
# text (level g). It compiles in two thirds to four fifths of the time with -O1, in seven tenths of that with -Og. No part
# of it takes time when a scene runs, and what a benchmark measures is in the libraries. With the address sanitizer, such
# code omits the check of variables that are used after their scope, which takes a third of the compile time. The fuzz
# targets (scripts/fuzz.sh) have it for all readers.
function(selvedge_optimize_less target)
  set(level 1)
  if(ARGC GREATER 1)
    set(level ${ARGV1})
  endif()
  if(EMSCRIPTEN AND level STREQUAL "g")  # Emscripten 3.1.6 rejects -Og
    set(level 1)
  endif()
  target_compile_options(${target} PRIVATE
                         $<$<AND:$<CXX_COMPILER_ID:GNU,Clang>,$<CONFIG:Release>>:-O${level}>
                         $<$<AND:$<CXX_COMPILER_ID:GNU,Clang>,$<CONFIG:RelWithDebInfo>>:-O1>)
  if(CMAKE_CXX_FLAGS MATCHES "-fsanitize=address")
    target_compile_options(${target} PRIVATE -fno-sanitize-address-use-after-scope)
  endif()
endfunction()

# selvedge_precompile(TARGET [HEADER LIBRARIES...]) lets the target use cmake/HEADER.h (default: precompiled) as a
# precompiled header. A target that links only LIBRARIES compiles it once for all libraries and once for all programs,
# because a compiler rejects a precompiled header that was made with other options or definitions. Headers that end in
# _json, _test or _bench are for sources that selvedge_optimize_less suits.
function(selvedge_precompile target)
  set(header precompiled)
  if(ARGC GREATER 1)
    list(POP_FRONT ARGN header)
  endif()
  set(level "")
  if(header MATCHES "_(test|bench)$")
    set(level 1)
  elseif(header MATCHES "_json$")
    set(level g)
  endif()
  if(level)
    selvedge_optimize_less(${target} ${level})
  endif()
  if(NOT SELVEDGE_PCH)
    return()
  endif()
  # A target that does not link one of these libraries still needs its definitions.
  foreach(library IN LISTS ARGN)
    target_compile_definitions(${target} PRIVATE $<TARGET_PROPERTY:${library},INTERFACE_COMPILE_DEFINITIONS>)
  endforeach()
  get_target_property(type ${target} TYPE)
  set(maker selvedge_${header}_of_${type})
  if(NOT TARGET ${maker})
    set(source ${PROJECT_BINARY_DIR}/${header}.cpp)
    if(type STREQUAL "EXECUTABLE")
      file(CONFIGURE OUTPUT ${source} CONTENT "int main() {}\n")
      add_executable(${maker} EXCLUDE_FROM_ALL ${source})
    else()
      set(source ${PROJECT_BINARY_DIR}/${header}_library.cpp)
      file(CONFIGURE OUTPUT ${source} CONTENT "namespace {}\n")
      add_library(${maker} STATIC EXCLUDE_FROM_ALL ${source})
    endif()
    selvedge_target_defaults(${maker})
    if(level)
      selvedge_optimize_less(${maker} ${level})
    endif()
    target_link_libraries(${maker} PRIVATE Eigen3::Eigen ${ARGN})
    target_compile_definitions(${maker} PRIVATE $<$<BOOL:${SELVEDGE_VALIDATION}>:SELVEDGE_VALIDATION=1>)
    target_precompile_headers(${maker} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/${header}.h)
  endif()
  target_precompile_headers(${target} REUSE_FROM ${maker})
endfunction()

# selvedge_alone(SOURCES...): sources of kernels in vectors (core/base/internal/vector_target.h). They compile without precompiled
# headers and outside of unity batches.
function(selvedge_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_PRECOMPILE_HEADERS ON SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

function(selvedge_library name)
  cmake_parse_arguments(ARG "FOLDER" "" "EXCEPT;SOURCES;HEADERS;DEPENDS;PRIVATE" ${ARGN})
  set(target selvedge_${name})
  if(ARG_FOLDER)
    set(here ${CMAKE_CURRENT_SOURCE_DIR})
    file(GLOB sources CONFIGURE_DEPENDS RELATIVE ${here} *.cpp detail/*.cpp)
    if(ARG_EXCEPT)
      file(GLOB except CONFIGURE_DEPENDS RELATIVE ${here} ${ARG_EXCEPT})
      list(REMOVE_ITEM sources ${except})
    endif()
    list(APPEND ARG_SOURCES ${sources})
  endif()
  add_library(${target} STATIC ${ARG_SOURCES})
  add_library(selvedge::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} SELVEDGE_HEADERS "${ARG_HEADERS}")
  selvedge_target_defaults(${target})
  selvedge_unite(${target})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${SELVEDGE_INCLUDE_DIR}> $<INSTALL_INTERFACE:include>)
  target_link_libraries(${target} PUBLIC Eigen3::Eigen ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE})
  target_compile_definitions(${target} PUBLIC $<$<BOOL:${SELVEDGE_VALIDATION}>:SELVEDGE_VALIDATION=1>)
  if("nlohmann_json::nlohmann_json" IN_LIST ARG_PRIVATE)
    selvedge_precompile(${target} precompiled_json fmt::fmt nlohmann_json::nlohmann_json)
  else()
    selvedge_precompile(${target})
  endif()
  set_property(GLOBAL APPEND PROPERTY SELVEDGE_COMPONENTS ${name})
endfunction()

# selvedge_umbrella(NAME DEPENDS ...) makes the target selvedge_NAME, alias selvedge::NAME, that stands for other libraries.
function(selvedge_umbrella name)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  add_library(selvedge_${name} INTERFACE)
  add_library(selvedge::${name} ALIAS selvedge_${name})
  set_target_properties(selvedge_${name} PROPERTIES EXPORT_NAME ${name})
  target_link_libraries(selvedge_${name} INTERFACE ${ARG_DEPENDS})
  set_property(GLOBAL APPEND PROPERTY SELVEDGE_COMPONENTS ${name})
endfunction()

# selvedge_adapter(NAME OPTION PACKAGE ... LICENCE ... SOURCES ... HEADERS ... DEPENDS ... PRIVATE ...) makes a separate
# library of the code that needs the package, if SELVEDGE_OPTION is on and the package is found. Otherwise it reports
# that the library is absent. HEADERS are installed only with the library. A private part in $<BUILD_INTERFACE:...> is not
# required of users of the installed library.
function(selvedge_adapter name option)
  cmake_parse_arguments(ARG "" "LICENCE" "PACKAGE;SOURCES;HEADERS;DEPENDS;PRIVATE" ${ARGN})
  if(NOT SELVEDGE_${option})
    return()
  endif()
  list(GET ARG_PACKAGE 0 package)
  set(CMAKE_MESSAGE_LOG_LEVEL WARNING)  # Some packages print messages even with QUIET.
  find_package(${ARG_PACKAGE} QUIET)
  unset(CMAKE_MESSAGE_LOG_LEVEL)
  if(NOT ${package}_FOUND)
    message(STATUS "${package} not found: selvedge::${name} is not built")
    return()
  endif()
  selvedge_uses(${package} "${${package}_VERSION}" ${ARG_LICENCE})
  selvedge_library(${name} SOURCES ${ARG_SOURCES} HEADERS ${ARG_HEADERS} DEPENDS ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE})
endfunction()
