# SPDX-License-Identifier: MIT
# Finds OSMesa, Mesa's off-screen renderer, by pkg-config, because it ships no CMake file. Defines OSMesa::OSMesa.
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(OSMESA QUIET IMPORTED_TARGET osmesa)
endif()
set(OSMesa_VERSION ${OSMESA_VERSION})
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OSMesa REQUIRED_VARS OSMESA_LINK_LIBRARIES
                                  REASON_FAILURE_MESSAGE "pkg-config knows no osmesa")
if(OSMesa_FOUND AND NOT TARGET OSMesa::OSMesa)
  add_library(OSMesa::OSMesa INTERFACE IMPORTED)
  target_link_libraries(OSMesa::OSMesa INTERFACE PkgConfig::OSMESA)
endif()
