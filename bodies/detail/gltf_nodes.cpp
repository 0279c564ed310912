// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/gltf_nodes.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

namespace selvedge::detail {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMostNodes = 1'000'000;  // far beyond any real scene

/// The JSON text of the file: all of a .gltf, the first chunk of a .glb.
std::string json_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(in), {});
  constexpr std::size_t header = 20;  // of the file and of its first chunk
  if (!text.starts_with("glTF") || text.size() < header) return text;
  std::uint32_t length = 0;
  std::memcpy(&length, text.data() + 12, sizeof length);
  return text.substr(header, length);
}

std::vector<std::vector<std::size_t>> children_of(const Json& root) {
  std::vector<std::vector<std::size_t>> children;
  if (!root.is_object() || !root.contains("nodes") || !root["nodes"].is_array()) return children;
  for (const Json& node : root["nodes"]) {
    std::vector<std::size_t>& list = children.emplace_back();
    if (!node.is_object() || !node.contains("children") || !node["children"].is_array()) continue;
    for (const Json& child : node["children"])
      if (child.is_number_unsigned()) list.push_back(child.get<std::size_t>());
  }
  return children;
}

/// Number of nodes that each node stands for: itself and those below it, at most kMostNodes + 1.
/// Nodes are finished after their children; what is left over is in a cycle.
std::uint64_t largest_tree(const std::vector<std::vector<std::size_t>>& children) {
  const std::size_t n = children.size();
  std::vector<std::vector<std::size_t>> parents(n);
  std::vector<std::size_t> open(n, 0), ready;
  for (std::size_t i = 0; i < n; ++i)
    for (const std::size_t child : children[i])
      if (child < n) parents[child].push_back(i), ++open[i];
  for (std::size_t i = 0; i < n; ++i)
    if (open[i] == 0) ready.push_back(i);
  std::vector<std::uint64_t> size(n, 1);
  std::uint64_t largest = 0;
  for (std::size_t k = 0; k < ready.size(); ++k) {
    largest = std::max(largest, size[ready[k]]);
    for (const std::size_t parent : parents[ready[k]]) {
      size[parent] = std::min(kMostNodes + 1, size[parent] + size[ready[k]]);
      if (--open[parent] == 0) ready.push_back(parent);
    }
  }
  return ready.size() < n ? kMostNodes + 1 : largest;
}

bool is_gltf(const std::string& file) {
  const auto ends = [&](const std::string& ending) {
    return file.size() >= ending.size() &&
           std::equal(ending.rbegin(), ending.rend(), file.rbegin(), [](char a, char b) {
             return a == std::tolower(static_cast<unsigned char>(b));
           });
  };
  return ends(".gltf") || ends(".glb");
}

}  // namespace

std::string gltf_node_fault(const std::string& file) {
  if (!is_gltf(file)) return "";
  const Json root = Json::parse(json_of(file), nullptr, /*allow_exceptions=*/false);
  if (largest_tree(children_of(root)) <= kMostNodes) return "";
  return "its nodes are children of several nodes, which makes more than " +
         std::to_string(kMostNodes) + " of them";
}

}  // namespace selvedge::detail
