// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/pictures/internal/result_view.h>
#include <selvedge/scene/build.h>

#include <optional>
#include <string>
#include <vector>

namespace selvedge::detail {

/// A scene and the parts that were built from it.
struct SceneOfView {
  Scene scene;
  BuiltScene built;
};

/// Collects values of the vertices, frame by frame, and turns them into bytes.
class FieldMaker {
 public:
  /// `scene` may be null, which leaves out strain and shortfall; it must outlive this.
  FieldMaker(const SceneOfView* scene, bool shortfall);

  /// Measures a frame: cloth with the values of its file, and the bodies (may be null).
  void add(const TriangleMesh& cloth, const std::vector<NamedValues>& values,
           const TriangleMesh* bodies);
  /// The fields with a value that is not zero, strain first.
  std::vector<ViewField> fields() const;

 private:
  /// Values of one kind: a list per frame, empty where they are unknown or all 0.
  using Series = std::vector<std::vector<float>>;

  void add_strain(const TriangleMesh& cloth);
  void add_shortfall(const TriangleMesh& cloth, const TriangleMesh* bodies);
  void add_named(const std::vector<NamedValues>& values, const std::string& name, Series& series);
  std::int32_t piece(std::int32_t vertex) const;

  const SceneOfView* scene_;
  bool wants_shortfall_;
  std::optional<ContactPairs> pairs_;
  std::vector<std::int32_t> piece_, body_;  // of each vertex of the cloth and of the joined bodies
  Series strain_, shortfall_, pressure_, flags_, sides_;
};

/// Bytes of values: see ViewScale. `full`: value at full colour.
ViewField make_field(ViewField description, const std::vector<std::vector<float>>& values);

/// The value below which a share of the absolute values that are not zero lie; 0 without any.
double quantile_of(const std::vector<std::vector<float>>& values, double share);

}  // namespace selvedge::detail
