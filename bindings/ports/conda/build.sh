#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The steps of meta.yaml. conda sets PREFIX, SP_DIR (folder of Python packages), PYTHON and CPU_COUNT.
set -euo pipefail
# shellcheck disable=SC2086
cmake -S . -B build/conda -G Ninja ${CMAKE_ARGS:-} -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$PREFIX" -DCMAKE_INSTALL_LIBDIR=lib \
  -DCMAKE_PREFIX_PATH="$PREFIX" -DSELVEDGE_UNITY=ON -DSELVEDGE_INSTALL=ON -DSELVEDGE_APPS=ON -DSELVEDGE_PYTHON=ON -DSELVEDGE_PYTHON_DIR="$SP_DIR" \
  -DPython_EXECUTABLE="$PYTHON" -DSELVEDGE_ASSIMP=OFF -DSELVEDGE_FCL=OFF -DSELVEDGE_LIBCCD=OFF -DSELVEDGE_EMBREE=OFF -DSELVEDGE_OSMESA=OFF \
  -DSELVEDGE_PAGMO=OFF
cmake --build build/conda --parallel "${CPU_COUNT:-1}"
cmake --install build/conda
