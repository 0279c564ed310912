# SPDX-License-Identifier: MIT
# Finds OSMesa, Mesa's off-screen renderer, by pkg-config, because it ships no CMake file. Defines OSMesa::headers
# only: the library is loaded when it is needed (broadphase/image_space/detail/mesa.h).
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(OSMESA QUIET osmesa)
endif()
set(OSMesa_VERSION ${OSMESA_VERSION})
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OSMesa REQUIRED_VARS OSMESA_LINK_LIBRARIES
                                  REASON_FAILURE_MESSAGE "pkg-config knows no osmesa")
if(OSMesa_FOUND AND NOT TARGET OSMesa::headers)
  add_library(OSMesa::headers INTERFACE IMPORTED)
  target_include_directories(OSMesa::headers INTERFACE ${OSMESA_INCLUDE_DIRS})
endif()
