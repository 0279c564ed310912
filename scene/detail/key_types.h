// SPDX-License-Identifier: MIT
//
// Types of keys that the structs of a scene do not have in the same form, and ranges that several
// keys have.
#pragma once

#include <selvedge/core/base/fields.h>
#include <selvedge/scene/scene.h>

#include <cstdint>
#include <map>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace selvedge {

inline constexpr ValueRange kRestGap{1e-12, 0.1};
inline constexpr ValueRange kFriction{0, 1e6};
inline constexpr ValueRange kLength{1e-9, 1e4};
inline constexpr ValueRange kSeeds{0, 4294967295};
inline constexpr ValueRange kIndices{0, 2147483647};
/// Most poses of a motion.
inline constexpr std::size_t kKeyframes = 1000000;
/// Of each component of a vector, unless its key has a range.
inline constexpr ValueRange kCoordinate{-1e6, 1e6};

/// Two members that a file gives as a list of two.
template <class Value>
struct PairView {
  Value &a, &b;
};
template <class T, class Value>
struct PairField {
  Value T::*a;
  Value T::*b;
  auto operator()(auto& record) const { return PairView{record.*a, record.*b}; }
};

/// A method by its name, or as an object with the name ("type") and options.
template <class Name, class Options>
struct MethodView {
  Name& name;
  Options& options;
  std::size_t family;      ///< among kMethodKeys
  bool or_switch = false;  ///< true (the default) or false (none) instead of a name
};
template <class T>
struct MethodField {
  std::string T::*name;
  MethodOptions T::*options;
  std::size_t family;
  bool or_switch = false;
  auto operator()(auto& record) const {
    return MethodView{record.*name, record.*options, family, or_switch};
  }
};

/// A list of formats: names, or objects with the name ("type") and options.
template <class Names, class Options>
struct FormatsView {
  Names& names;
  Options& options;
};
struct FormatsField {
  auto operator()(auto& output) const { return FormatsView{output.formats, output.format_options}; }
};

// clang deduces the arguments of aggregates by itself from its version 17 on.
template <class Value>
PairView(Value&, Value&) -> PairView<Value>;
template <class T, class Value>
PairField(Value T::*, Value T::*) -> PairField<T, Value>;
template <class Name, class Options>
MethodView(Name&, Options&, std::size_t, bool = false) -> MethodView<Name, Options>;
template <class T>
MethodField(std::string T::*, MethodOptions T::*, std::size_t, bool = false) -> MethodField<T>;
template <class Names, class Options>
FormatsView(Names&, Options&) -> FormatsView<Names, Options>;
template <class Outer, class Inner>
FieldWithin(Outer, Inner) -> FieldWithin<Outer, Inner>;

/// A fabric as the sheet of a laboratory.
struct FabricSheet {};
/// The keys of a material.
struct MaterialKeys {
  Material material;
};

struct AxisAngle {
  Vec3 axis = Vec3::UnitZ();
  double angle_deg = 0.0;
};

using FileOrMesh = std::variant<std::string, TriangleMesh>;
/// The name of one of the motions, or its keyframes themselves.
using MotionKey = std::variant<std::string, std::vector<Keyframe>>;

/// Sides and corners of a grid by name, and vertices by number.
using ParticleList = std::vector<std::variant<std::string, std::int32_t>>;
using RowKey = std::variant<std::string, ParticleList>;
struct BoxKey {};
/// The same, or all particles within a box.
using SelectKey = std::variant<std::string, ParticleList, BoxKey>;

/// One side of a seam.
struct SideKey {};

struct GarmentSewing {
  double pull = SewingConfig{}.pull;
  double merge = 0.004;
};
/// The panels of a sewing pattern.
struct GarmentKeys {
  std::filesystem::path sewing_pattern;
  double edge_length = 0.01;
  UpAxis up = UpAxis::z;
  std::map<std::string, Vec3> panels;  ///< m, way of a panel from its place in the file
  GarmentSewing sewing;
};

/// A piece of cloth as files give it: the keys of its shape beside those of every piece.
template <class Shape>
struct PieceOf {
  ClothSpec cloth;
  Shape shape;
};
using PieceKey = std::variant<PieceOf<ClothFile>, PieceOf<GarmentKeys>, PieceOf<ClothGrid>>;

struct SequenceKeys {
  double fps = BodySequence{}.fps;
};
/// An obstacle as files give it.
template <class Shape>
struct BodyOf {
  BodySpec body;
  Shape shape;
  SolidSpec solid;  // of mass 0: none
};
using ObstacleKey = std::variant<BodyOf<BodyShape>, BodyOf<BodyFile>, BodyOf<BodySequence>>;

namespace detail {

inline Key name_key() {
  return {.text = "Name, unique in its list; by default made from the place in the list",
          .shortest = 1,
          .longest = 100};
}

/// A key that the reader stores by hand and whose default is an empty list or group.
template <class T>
Unstored<T> empty_by_default() {
  return {T{}};
}

}  // namespace detail
}  // namespace selvedge
