# SPDX-License-Identifier: MIT
# Installs the public headers, one export component per module, the program and the package config, so that
# find_package(selvedge COMPONENTS core broadphase) requires only the packages that core and broadphase need.
if(NOT SELVEDGE_INSTALL)
  return()
endif()
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(SELVEDGE_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/selvedge)

# Maps an imported target, or the part before its "::", to the arguments of find_dependency.
set(selvedge_package_of_Eigen3 "Eigen3 3.4 NO_MODULE")
set(selvedge_package_of_TBB "TBB")
set(selvedge_package_of_assimp "assimp")
set(selvedge_package_of_nlohmann_json "nlohmann_json 3.11")
set(selvedge_package_of_fmt "fmt 9")
set(selvedge_package_of_fcl "fcl")
set(selvedge_package_of_ccd "ccd")
set(selvedge_package_of_embree "embree 3")
set(selvedge_package_of_OSMesa "OSMesa")
set(selvedge_package_of_PNG "PNG")
set(selvedge_package_of_Pagmo "pagmo")

# Writes the requirements of a module for the config file into `out`: the modules and packages it links.
function(selvedge_requirements module out)
  get_target_property(libraries selvedge_${module} LINK_LIBRARIES)
  set(needs)
  set(lines)
  foreach(library IN LISTS libraries)
    if(library MATCHES "^selvedge(::|_)(.+)$")
      list(APPEND needs ${CMAKE_MATCH_2})
    elseif(NOT library MATCHES "^Threads::" AND library MATCHES "^([A-Za-z0-9_]+)(::|$)")
      set(package ${CMAKE_MATCH_1})
      if(NOT DEFINED selvedge_package_of_${package})
        message(FATAL_ERROR "selvedge_${module} links ${library}: name its package in cmake/selvedge_install.cmake")
      endif()
      string(APPEND lines "\n  find_dependency(${selvedge_package_of_${package}})")
    endif()
  endforeach()
  set(text "set(selvedge_needs_${module} ${needs})\n")
  string(APPEND text "macro(selvedge_find_packages_of_${module})${lines}\nendmacro()\n")
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

get_property(SELVEDGE_MODULES GLOBAL PROPERTY SELVEDGE_MODULES)
set(SELVEDGE_REQUIREMENTS)
# Headers that a module installs whose name differs from its folder's.
foreach(module IN LISTS SELVEDGE_MODULES)
  get_target_property(folder selvedge_${module} SOURCE_DIR)
  cmake_path(GET folder FILENAME folder_name)
  get_target_property(headers selvedge_${module} SELVEDGE_HEADERS)
  if(headers)
    list(APPEND SELVEDGE_NAMED_HEADERS_${folder_name} ${headers})
  endif()
endforeach()
# Headers of modules that are not built are not installed.
list(APPEND SELVEDGE_NAMED_HEADERS_lab measure_result.h)
list(APPEND SELVEDGE_NAMED_HEADERS_broadphase image_space.h)
foreach(module IN LISTS SELVEDGE_MODULES)
  install(TARGETS selvedge_${module} EXPORT selvedge_${module} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(EXPORT selvedge_${module} NAMESPACE selvedge:: FILE selvedge-${module}-targets.cmake
          DESTINATION ${SELVEDGE_CONFIG_DIR})
  get_target_property(folder selvedge_${module} SOURCE_DIR)
  cmake_path(GET folder FILENAME folder_name)
  get_target_property(headers selvedge_${module} SELVEDGE_HEADERS)
  if(NOT headers)
    file(GLOB headers RELATIVE ${folder} ${folder}/*.h)
    list(REMOVE_ITEM headers ${SELVEDGE_NAMED_HEADERS_${folder_name}})
  endif()
  list(TRANSFORM headers PREPEND ${folder}/)
  install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/selvedge/${folder_name})
  selvedge_requirements(${module} text)
  string(APPEND SELVEDGE_REQUIREMENTS "${text}")
endforeach()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/selvedge-config.cmake.in
                              ${PROJECT_BINARY_DIR}/selvedge-config.cmake INSTALL_DESTINATION ${SELVEDGE_CONFIG_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/selvedge-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/selvedge-config.cmake ${PROJECT_BINARY_DIR}/selvedge-config-version.cmake
              ${CMAKE_CURRENT_LIST_DIR}/FindOSMesa.cmake
        DESTINATION ${SELVEDGE_CONFIG_DIR})

if(TARGET selvedge_program)
  install(TARGETS selvedge_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/data/ DESTINATION ${CMAKE_INSTALL_DATADIR}/selvedge PATTERN "fetched" EXCLUDE)
endif()
