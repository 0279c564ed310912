# SPDX-License-Identifier: MIT
# Overlay port: vcpkg install selvedge[simulation,judge] --overlay-ports=bindings/ports/vcpkg
# builds the tree that contains it. What was run of it: docs/lab/platforms.md.
cmake_path(ABSOLUTE_PATH CMAKE_CURRENT_LIST_DIR NORMALIZE OUTPUT_VARIABLE port)
cmake_path(SET SOURCE_PATH NORMALIZE "${port}/../../../..")

vcpkg_check_features(OUT_FEATURE_OPTIONS options FEATURES
  judge SELVEDGE_JUDGE
  simulation SELVEDGE_SIMULATION)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}" OPTIONS ${options} -DSELVEDGE_UNITY=ON -DSELVEDGE_INSTALL=ON -DSELVEDGE_APPS=OFF
  -DSELVEDGE_C=OFF -DSELVEDGE_RENDER=OFF -DSELVEDGE_ASSIMP=OFF -DSELVEDGE_FCL=OFF -DSELVEDGE_LIBCCD=OFF -DSELVEDGE_EMBREE=OFF
  -DSELVEDGE_OSMESA=OFF -DSELVEDGE_PAGMO=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/selvedge)
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
