# SPDX-License-Identifier: MIT
# Finds OSMesa, Mesa's renderer into memory, by pkg-config: it brings no CMake file of its own. Makes OSMesa::OSMesa.
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(OSMESA QUIET IMPORTED_TARGET osmesa)
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OSMesa REQUIRED_VARS OSMESA_LINK_LIBRARIES
                                  REASON_FAILURE_MESSAGE "pkg-config knows no osmesa")
if(OSMesa_FOUND AND NOT TARGET OSMesa::OSMesa)
  add_library(OSMesa::OSMesa INTERFACE IMPORTED)
  target_link_libraries(OSMesa::OSMesa INTERFACE PkgConfig::OSMESA)
endif()
