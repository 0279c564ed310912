# SPDX-License-Identifier: MIT
# selvedge_module(NAME SOURCES ... DEPENDS ... PRIVATE ...) makes the library selvedge_NAME, alias selvedge::NAME.
# In the build tree include/selvedge links to the source root, so that <selvedge/core/types.h> reads the same
# in-tree and installed.
set(SELVEDGE_INCLUDE_DIR ${PROJECT_BINARY_DIR}/include)
file(MAKE_DIRECTORY ${SELVEDGE_INCLUDE_DIR})
file(CREATE_LINK ${PROJECT_SOURCE_DIR} ${SELVEDGE_INCLUDE_DIR}/selvedge SYMBOLIC)

if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
find_program(SELVEDGE_CCACHE ccache)
if(SELVEDGE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${SELVEDGE_CCACHE})
endif()
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
list(PREPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})  # FindOSMesa
find_package(Eigen3 3.4 REQUIRED NO_MODULE)

# Warnings and the floating-point rules that determinism needs, for our own targets only. g++ 12 reports
# -Wrestrict inside its own std::string (GCC bug 105651), which must not stop CI.
function(selvedge_target_defaults target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -ffp-contract=off
                         "$<$<BOOL:${SELVEDGE_WERROR}>:-Werror;-Wno-error=restrict>")
endfunction()

function(selvedge_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE" ${ARGN})
  set(target selvedge_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  add_library(selvedge::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  selvedge_target_defaults(${target})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${SELVEDGE_INCLUDE_DIR}> $<INSTALL_INTERFACE:include>)
  target_link_libraries(${target} PUBLIC Eigen3::Eigen ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE})
  target_compile_definitions(${target} PUBLIC $<$<BOOL:${SELVEDGE_VALIDATION}>:SELVEDGE_VALIDATION=1>)
  set_property(GLOBAL APPEND PROPERTY SELVEDGE_MODULES ${name})
endfunction()

# selvedge_adapter(NAME OPTION PACKAGE ... SOURCES ... HEADERS ... DEPENDS ... PRIVATE ...) makes a module of its own
# out of what needs the package, if SELVEDGE_OPTION is on and the package is there; else says that it is absent.
# HEADERS are installed with it alone; a private part in $<BUILD_INTERFACE:...> is not asked of who uses the installed
# library.
function(selvedge_adapter name option)
  cmake_parse_arguments(ARG "" "" "PACKAGE;SOURCES;HEADERS;DEPENDS;PRIVATE" ${ARGN})
  if(NOT SELVEDGE_${option})
    return()
  endif()
  list(GET ARG_PACKAGE 0 package)
  set(CMAKE_MESSAGE_LOG_LEVEL WARNING)  # Some packages talk even when told to be quiet.
  find_package(${ARG_PACKAGE} QUIET)
  unset(CMAKE_MESSAGE_LOG_LEVEL)
  if(NOT ${package}_FOUND)
    message(STATUS "${package} not found: selvedge::${name} is not built")
    return()
  endif()
  selvedge_module(${name} SOURCES ${ARG_SOURCES} DEPENDS ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE})
  set_target_properties(selvedge_${name} PROPERTIES SELVEDGE_HEADERS "${ARG_HEADERS}")
endfunction()
