// SPDX-License-Identifier: MIT
//
// The node tree of a glTF file before assimp builds it. Only selvedge-assimp includes this.
#pragma once

#include <string>

namespace selvedge::detail {

/// A fault of the nodes of a .gltf or .glb file, else "". A node that is a child of two nodes is
/// built twice, so that a file of a kilobyte may name 2^40 nodes, or endlessly many. Files of other
/// formats and files that are not JSON have no such fault; assimp reports theirs.
std::string gltf_node_fault(const std::string& file);

}  // namespace selvedge::detail
