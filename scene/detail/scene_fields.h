// SPDX-License-Identifier: MIT
//
// The keys of scene files: for each struct of a scene the list of its fields. Reader, range check,
// schema, scene_keys() and the table in docs/scene_files.md are made from these lists. A new key
// needs its member and its line here.
#pragma once

#include <selvedge/core/base/fields.h>
#include <selvedge/core/cloth/internal/material_fields.h>
#include <selvedge/scene/detail/key_types.h>
#include <selvedge/scene/scene.h>

namespace selvedge {

// -- sections ------------------------------------------------------------------------------------

template <>
struct Fields<PerturbationSpec> {
  static void visit(auto&& visitor) {
    using T = PerturbationSpec;
    visitor("speed", &T::speed,
            Key{.unit = "m/s",
                .range = {0, 1000},
                .text = "Largest speed in each coordinate, added to the velocity of the piece"});
    visitor("seed", &T::seed, Key{.unit = "1", .range = kSeeds, .text = "Selects the velocities"});
  }
};

template <>
struct Fields<AirGusts> {
  static void visit(auto&& visitor) {
    using T = AirGusts;
    visitor("speed", &T::speed,
            Key{.unit = "m/s",
                .range = {0, 1000},
                .text = "Root mean square of each component; 0: none"});
    visitor(
        "length", &T::length,
        Key{.unit = "m", .range = {1e-6, 1e6}, .text = "Length over which gusts are correlated"});
    visitor("seed", &T::seed, Key{.unit = "1", .range = kSeeds, .text = "Selects the gusts"});
  }
};

template <>
struct Fields<AirJet> {
  static constexpr const char* kText = "A round turbulent jet of air.";
  static void visit(auto&& visitor) {
    using T = AirJet;
    visitor("position", &T::position,
            Key{.unit = "m", .text = "Centre of the nozzle", .required = true});
    visitor("direction", &T::direction,
            Key{.unit = "1", .text = "Of the flow; of any length but 0", .required = true});
    visitor("speed", &T::speed,
            Key{.unit = "m/s",
                .range = {0, 1000},
                .text = "At the nozzle, in the middle",
                .required = true});
    visitor("diameter", &T::diameter,
            Key{.unit = "m", .range = {1e-6, 1000}, .text = "Of the nozzle"});
  }
};

template <>
struct Fields<AirConfig> {
  static void visit(auto&& visitor) {
    using T = AirConfig;
    visitor("wind", &T::wind,
            Key{.unit = "m/s", .text = "Uniform velocity of the air; gusts and jets are added"});
    visitor("gusts", &T::gusts, Key{.text = "Random turbulence that the wind carries along"});
    visitor("jets", &T::jets, Key{.text = "Round turbulent jets, as from fans", .longest = 1000});
    visitor("normal_drag", &T::normal_drag,
            Key{.unit = "N·s/m³",
                .range = {0, 1000},
                .text = "Drag of a triangle against flow across it, per area"});
    visitor("viscous_drag", &T::viscous_drag,
            Key{.unit = "N·s/m³",
                .range = {0, 1000},
                .text = "Drag of a particle in any direction, per area"});
  }
};

template <>
struct Fields<TimeSpec> {
  static void visit(auto&& visitor) {
    using T = TimeSpec;
    visitor("frames", &T::frames,
            Key{.unit = "1", .range = {1, 99999}, .text = "Frames after the start frame"});
    visitor("until", &T::until_rest,
            Key{.text = "Whether the run ends with the last frame or, if this is earlier, once the "
                        "cloth is at rest and no motion, release or water is still to come: forces "
                        "balanced to 1e-3 of its weight",
                .words = {"end", "rest"}});
    visitor("fps", &T::fps,
            Key{.unit = "1/s", .range = {0.1, 100000}, .text = "Frames per second"});
    visitor("steps_per_frame", &T::steps_per_frame,
            Key{.unit = "1",
                .range = {1, 1000},
                .text = "Steps of the integrator per frame; more cost time and buy accuracy"});
    visitor("step_error", &T::step_error,
            Key{.unit = "1",
                .range = {0, 1},
                .text = "Two steps of a frame are taken as one while the error of the longer step, "
                        "by the size of a piece (the root of its area), is estimated to stay below "
                        "step_error / steps_per_frame^2; 0: never"});
    visitor("sleep_speed", &T::sleep_speed,
            Key{.unit = "m/s",
                .range = {0, 1},
                .text = "Speed that no particle of the cloth exceeds for half a second before the "
                        "cloth sleeps: its steps are left out until a body, a handle or a program "
                        "acts on it; 0: never"});
    visitor("max_halvings", &T::max_halvings,
            Key{.unit = "1",
                .range = {0, 20},
                .text = "How often a step that cannot be made clean is halved before the run is "
                        "given up"});
    visitor("energy_guard", &T::energy_guard,
            Key{.text = "Halve implicit steps that gain energy without a source; otherwise the "
                        "gain is only counted"});
  }
};

template <>
struct Fields<PairSpec> {
  static void visit(auto&& visitor) {
    using T = PairSpec;
    visitor("a", &T::a,
            Key{.text = "Name of a piece of cloth, of a material (every piece of it) or of an "
                        "obstacle",
                .shortest = 1,
                .required = true});
    visitor("b", &T::b,
            Key{.text = "The other one, in any order; the same name for cloth on itself. Not two "
                        "obstacles",
                .shortest = 1,
                .required = true});
    visitor("friction", &T::friction,
            Key{.unit = "1",
                .range = kFriction,
                .text = "Coulomb coefficient of this pair; if left out, the obstacle's, or the "
                        "larger of the two fabrics'"});
    visitor("rest_gap", &T::rest_gap,
            Key{.unit = "m",
                .range = kRestGap,
                .text = "Distance that contacts of this pair keep at rest; if left out, "
                        "contact.rest_gap"});
    visitor("collide", &T::collide,
            Key{.text = "false: these cannot collide, so detection leaves them out; the check of "
                        "every frame still reports where they cross. If left out, true"});
  }
};

template <>
struct Fields<ContactSpec> {
  static void visit(auto&& visitor) {
    using T = ContactSpec;
    visitor("rest_gap", &T::rest_gap,
            Key{.unit = "m",
                .range = kRestGap,
                .text = "Distance that contacts keep between two surfaces at rest"});
    visitor("pairs", &T::pairs,
            Key{.text = "Pairs with values of their own; of several that match, the last one "
                        "counts, for each field separately"});
    visitor("self", &T::self,
            Key{.text = "Whether cloth collides with itself and with other pieces"});
    visitor("start", &T::untangle_start,
            Key{.text = "What is done about cloth that crosses a body or itself at the start: "
                        "refuse the scene, or untangle it in the first frames",
                .words = {"refuse", "untangle"}});
    visitor("still_tangled", &T::carry_tangled,
            Key{.text = "What is done where no way to untangle cloth is found, or where bodies "
                        "leave cloth no room: stop the run, or carry it on with the vertices "
                        "flagged",
                .words = {"stop", "carry"}});
    visitor("broad_phase", MethodField{&T::broad_phase, &T::broad_phase_options, 0},
            Key{.text = "Which method finds the pairs that could touch, by name or with its "
                        "options; `selvedge list` names them"});
    visitor("narrow_phase", MethodField{&T::narrow_phase, &T::narrow_phase_options, 1},
            Key{.text = "Which method decides whether a pair touches, by name or with its options; "
                        "`selvedge list` names them"});
    visitor("response", MethodField{&T::response, &T::response_options, 2},
            Key{.text = "Which method responds to contacts, by name or with its options; "
                        "`selvedge list` names them"});
    visitor("fail_safe", MethodField{&T::fail_safe, &T::fail_safe_options, 3},
            Key{.text = "Which method takes over where pairs still collide, by name or with its "
                        "options; `selvedge list` names them"});
  }
};

template <>
struct Fields<SolverSpec> {
  static void visit(auto&& visitor) {
    using T = SolverSpec;
    visitor("integrator", MethodField{&T::integrator, &T::integrator_options, 4},
            Key{.text = "Which method advances the motion, by name or with its options; `selvedge "
                        "list` names them. implicit_blend and implicit_euler: stable with large "
                        "steps; explicit ones need small steps"});
    visitor("strain_limiter", MethodField{&T::limiter, &T::limiter_options, 5, true},
            Key{.text = "What keeps springs within the strain limit of their material, by name or "
                        "with its options; `selvedge list` names them. true: position, false: "
                        "none"});
    visitor(
        "tolerance", &T::tolerance,
        Key{.unit = "1",
            .range = {1e-15, 0.1},
            .text = "Relative residual at which the linear solve of an implicit integrator stops"});
  }
};

template <>
struct Fields<CameraSpec> {
  static void visit(auto&& visitor) {
    using T = CameraSpec;
    visitor("eye", &T::eye, Key{.unit = "m", .text = "Position of the camera"});
    visitor("target", &T::target, Key{.unit = "m", .text = "Point in the middle of the picture"});
    visitor("field_of_view", &T::field_of_view,
            Key{.unit = "degrees", .range = {1, 150}, .text = "Vertical opening angle"});
  }
};

template <>
struct Fields<OutputSpec> {
  static void visit(auto&& visitor) {
    using T = OutputSpec;
    visitor("formats", FormatsField{},
            Key{.text = "Formats of the frames beside PLY, by name or with options: gltf (Blender, "
                        "browsers), mdd and pc2 (Blender), obj, usd, vtk (ParaView). The option "
                        "pressure of ply adds contact pressures",
                .longest = 16});
    visitor("camera", &T::camera,
            Key{.text = "Where pictures are taken from; by default so that all just fits"});
  }
};

// -- places and motions --------------------------------------------------------------------------

template <>
struct Fields<AxisAngle> {
  static constexpr const char* kName = "axis_angle";
  static constexpr const char* kText = "A rotation about an axis through the origin.";
  static void visit(auto&& visitor) {
    using T = AxisAngle;
    visitor("axis", &T::axis,
            Key{.unit = "1", .text = "Direction of the axis, any length but 0", .required = true});
    visitor("angle_deg", &T::angle_deg,
            Key{.unit = "degrees",
                .range = {-1e6, 1e6},
                .text = "Angle, counter-clockwise seen against the axis",
                .required = true});
  }
};

template <>
struct Fields<Placement> {
  static constexpr const char* kName = "transformation";
  static constexpr const char* kText = "Placement: rotated, then translated.";
  static void visit(auto&& visitor) {
    using T = Placement;
    visitor("translation", &T::translation,
            Key{.unit = "m", .text = "Where the origin of the geometry goes"});
    visitor("rotation", &T::rotation,
            Key{.text = "Rotation about the origin of the geometry, one or a list applied in "
                        "order"});
  }
};

template <>
struct Fields<Keyframe> {
  static constexpr const char* kName = "keyframe";
  static constexpr const char* kText =
      "A pose at a time; linear between two of them (rotations: spherical-linear), held before the "
      "first and after the last.";
  static void visit(auto&& visitor) {
    using T = Keyframe;
    visitor("time", &T::time,
            Key{.unit = "s", .range = {0, 1e6}, .text = "When", .required = true});
    visitor("translation", &T::translation, Key{.unit = "m", .text = "Way from the start"});
    visitor("rotation", &T::rotation,
            Key{.text = "Rotation from the start: of an obstacle about its own origin, of a handle "
                        "about the centre of its particles"});
  }
};

template <>
struct Fields<TriangleMesh> {
  static constexpr const char* kName = "inline_mesh";
  static constexpr const char* kText = "A small mesh that stands in the scene itself.";
  static void visit(auto&& visitor) {
    using T = TriangleMesh;
    visitor("vertices", &T::vertices,
            Key{.unit = "m", .text = "Positions", .longest = 100000, .required = true});
    visitor("triangles", &T::triangles,
            Key{.unit = "1",
                .range = kIndices,
                .text = "Numbers of three vertices each, from 0",
                .longest = 200000,
                .required = true});
  }
};

// -- cloth ---------------------------------------------------------------------------------------

template <>
struct Fields<RefineSpec> {
  static constexpr const char* kName = "refine";
  static void visit(auto&& visitor) {
    using T = RefineSpec;
    visitor("when", &T::when,
            Key{.text = "settled: all of them, once the piece has come to rest on the mesh it has; "
                        "curved: those that meet a neighbour at an angle",
                .words = {"", "settled", "curved"},
                .required = true});
    visitor("levels", &T::levels,
            Key{.unit = "1", .range = {1, 6}, .text = "How often a cell may be split"});
    visitor("speed", &T::speed,
            Key{.unit = "m/s", .range = {0, 1e6}, .text = "Of settled: no particle is faster"});
    visitor("energy", &T::energy,
            Key{.unit = "J",
                .range = {0, 1e9},
                .text = "Of settled: or the kinetic energy of the piece is below"});
    visitor("after", &T::after,
            Key{.unit = "s",
                .range = {0, 1e6},
                .text = "Of settled: not sooner after the start or the last split"});
    visitor("angle_deg", &T::angle_deg,
            Key{.unit = "degrees",
                .range = {0, 180},
                .text = "Of curved: angle between the normals of neighbours above which both are "
                        "split"});
    visitor("join_deg", &T::join_deg,
            Key{.unit = "degrees",
                .range = {0, 180},
                .text = "Of curved: the quarters of a cell, or the halves of bisected triangles, "
                        "are joined where they meet each other and their neighbours at no more "
                        "than this, below angle_deg; 0: never"});
  }
};

template <>
struct Fields<VirtualSpec> {
  static constexpr const char* kName = "virtual_springs";
  static void visit(auto&& visitor) {
    using T = VirtualSpec;
    visitor("stiffness", &T::stiffness,
            Key{.unit = "N/m³",
                .range = {0, 1e9},
                .text = "Force per area and distance",
                .required = true});
    visitor("follow", &T::follow,
            Key{.text = "Whether the places go along with the cloth, moved and turned as a whole; "
                        "else they stay where it starts"});
  }
};

template <>
struct Fields<SupportConstants> {
  static void visit(auto&& visitor) {
    using T = SupportConstants;
    visitor("stiffness", &T::stiffness,
            Key{.unit = "N/m",
                .range = {1e-9, 1e9},
                .text = "Force on a vertex per loss of volume by area"});
    visitor("share", &T::share,
            Key{.unit = "1",
                .range = {1e-6, 0.99},
                .text = "Part of it that the springs to the middle have"});
  }
};

template <>
struct Fields<StripPath> {
  static void visit(auto&& visitor) {
    using T = StripPath;
    visitor("points", &T::points,
            Key{.unit = "m",
                .text = "The curve runs smoothly through these points; its length is that of the "
                        "piece within 1 %",
                .shortest = 2,
                .longest = 10000,
                .required = true});
    visitor("side", &T::side,
            Key{.unit = "1",
                .text = "Where y of the grid points, as far as that is across the curve; a curve "
                        "that bends towards it stretches one border of the cloth"});
  }
};

namespace detail {

inline Key plate_key() {
  return {.unit = "1",
          .range = {-1, 0.99, true},
          .text =
              "Poisson's ratio of a plate with the material's stretch and bending stiffness, "
              "to which the springs of a triangular grid or flat mesh are fitted; springs have "
              "1/3, and the run reports what they cannot fit of another"};
}
inline Key refine_key() {
  return {.text =
              "Cells of the rectangular pattern, or triangles of the triangular pattern or of a "
              "mesh, are split in four, or cells joined again, when that is due before a frame "
              "and crosses nothing",
          .completed = false};
}

}  // namespace detail

template <>
struct Fields<GridConfig> {
  static void visit(auto&& visitor) {
    using T = GridConfig;
    visitor("size", PairField{&T::size_x, &T::size_y},
            Key{.unit = "m", .range = kLength, .text = "Sides along x and y"});
    visitor("cells", PairField{&T::cells_x, &T::cells_y},
            Key{.unit = "1",
                .range = {1, 5000},
                .text = "Cells along x and y; one more particle than cells"});
  }
};

template <>
struct Fields<ClothGrid> {
  static constexpr const char* kText =
      "A rectangle of cloth in the xy-plane, centred at its origin.";
  static void visit(auto&& visitor) {
    using T = ClothGrid;
    visitor("pattern", MethodField{&T::pattern, &T::pattern_options, 6},
            Key{.text = "Which springs the piece has, by name or with options; `selvedge list` "
                        "names the patterns. bilayered: cells are those of the dense layer; arc: a "
                        "disc of diameter size, cells are the particles of a ring and the rings"});
    visit_within<GridConfig>(&T::grid, visitor);
    visitor("path", &T::path,
            Key{.text = "A curve along which the piece lies at the start, folded or knotted: x of "
                        "the grid runs along it; at rest the piece is flat all the same",
                .completed = false});
    visitor("plate", &T::plate, detail::plate_key());
    visitor("refine", &T::refine, detail::refine_key());
  }
};

template <>
struct Fields<ClothFile> {
  static constexpr const char* kText =
      "A piece of cloth from a triangle mesh (OBJ, PLY or OFF, read exactly: file order, double "
      "precision).";
  static void visit(auto&& visitor) {
    using T = ClothFile;
    visitor("mesh", Unstored<FileOrMesh>{},
            Key{.text = "Initial shape; also the rest shape unless rest_mesh is given. Path "
                        "relative to the scene file, or the mesh itself",
                .shortest = 1,
                .required = true});
    visitor("texture_unit", Unstored<double>{1.0},
            Key{.unit = "m",
                .range = {1e-9, 1000},
                .text = "Metres per unit of the texture coordinates"});
    visitor("rest_mesh", Unstored<std::string>{""},
            Key{.text = "Rest shape with the same triangles. Path relative to the scene file; "
                        "texture: the texture coordinates of the OBJ file, a flat pattern; empty: "
                        "the mesh itself"});
    visitor("plate", &T::plate, detail::plate_key());
    visitor("refine", &T::refine, detail::refine_key());
    visitor("support", &T::support,
            Key{.text = "The mesh is a closed body: springs from every vertex to a particle in its "
                        "middle, and a push against loss of volume"});
  }
};

namespace detail {

inline Key pull_key() {
  return {.unit = "N/m", .range = {1e-9, 1e9}, .text = "Force by the distance of two particles"};
}

}  // namespace detail

template <>
struct Fields<SewingConfig> {
  static void visit(auto&& visitor) {
    using T = SewingConfig;
    visitor("pull", &T::pull, detail::pull_key());
    visitor("tolerance", &T::tolerance,
            Key{.unit = "m", .range = {1e-9, 10}, .text = "Nearer than this the pull is constant"});
    visitor("damping", &T::damping,
            Key{.unit = "N·s/m", .range = {0, 1e6}, .text = "Force by the rate of the distance"});
    visitor("acceleration", &T::acceleration,
            Key{.unit = "m/s²",
                .range = {0, 1e6},
                .text = "Further acceleration with which two particles approach each other"});
  }
};

namespace detail {

inline Key merge_key() {
  return {.unit = "m",
          .range = {0, 10},
          .text =
              "Distance at which the two particles of a pair become one; 0: never; else more "
              "than the rest gap"};
}

}  // namespace detail

template <>
struct Fields<GarmentSewing> {
  static void visit(auto&& visitor) {
    using T = GarmentSewing;
    visitor("pull", &T::pull, detail::pull_key());
    visitor("merge", &T::merge, detail::merge_key());
  }
};

template <>
struct Fields<GarmentKeys> {
  static constexpr const char* kText =
      "The panels of a sewing pattern, flat at rest, as the file places them; each stitch is a "
      "seam.";
  static void visit(auto&& visitor) {
    using T = GarmentKeys;
    visitor("sewing_pattern", &T::sewing_pattern,
            Key{.text = "Sewing pattern in the JSON format of GarmentCode. Path relative to the "
                        "scene file",
                .shortest = 1,
                .required = true});
    visitor("edge_length", &T::edge_length,
            Key{.unit = "m", .range = {0, 10, true}, .text = "Of the triangles"});
    visitor("up", &T::up,
            Key{.text = "Axis of the file that points up; it becomes z", .words = {"x", "y", "z"}});
    visitor("panels", &T::panels,
            Key{.unit = "m",
                .text = "How far panels start from their place in the file, by name, with z up"});
    visitor("sewing", &T::sewing, Key{.text = "How its seams are sewn"});
  }
};

/// The keys that all pieces have.
template <>
struct Fields<ClothSpec> {
  static void visit(auto&& visitor) {
    using T = ClothSpec;
    visitor(
        "virtual_springs", &T::virtual_springs,
        Key{.text = "A spring from every particle to its place at the start", .completed = false});
    visitor("scale", &T::scale,
            Key{.unit = "1",
                .range = {1e-9, 1e6},
                .text = "Factor on all lengths, the rest shape included"});
    visitor("transformation", &T::placement, Key{.text = "Where the piece lies at the start"});
    visitor("velocity", &T::velocity,
            Key{.unit = "m/s", .text = "Velocity of all its particles at the start"});
    visitor("material", &T::material, Key{.text = "Name of one of the materials"});
  }
};

template <class Shape>
struct Fields<PieceOf<Shape>> {
  static constexpr const char* kText = Fields<Shape>::kText;
  static void visit(auto&& visitor) {
    using T = PieceOf<Shape>;
    visitor("name", Unstored<std::string>{}, detail::name_key());
    visit_within<Shape>(&T::shape, visitor);
    visit_within<ClothSpec>(&T::cloth, visitor);
  }
};

// -- materials -----------------------------------------------------------------------------------

template <>
struct Fields<MaterialKeys> {
  static constexpr const char* kText = Fields<Material>::kText;
  static void visit(auto&& visitor) {
    visitor("fabric", Unstored<std::variant<std::string, FabricSheet>>{},
            Key{.text = "A measured fabric that the keys beside it change: one of `selvedge fabric "
                        "--list`, such as \"petrak_2025/M1\"; a fabric file, path relative to the "
                        "scene file; or the sheet itself with the keys of such a file, KES-F's "
                        "with its loops among them"});
    visit_within<Material>(&MaterialKeys::material, visitor);
  }
};

// -- particles -----------------------------------------------------------------------------------

template <>
struct Fields<BoxKey> {
  static void visit(auto&& visitor) {
    visitor("box", Unstored<std::array<Vec3, 2>>{},
            Key{.unit = "m",
                .text = "All particles that lie in this box at the start: its lowest and its "
                        "highest corner",
                .required = true});
  }
};

namespace detail {

std::string_view selection_text();
std::string_view row_text();

/// The piece and the particles that the reader looks up.
template <class Select>
void visit_selection(auto&& visitor, std::string_view text = selection_text()) {
  visitor("geometry", Unstored<std::string>{},
          Key{.text = "Name of the piece; may be left out if there is only one", .shortest = 1});
  visitor("select", Unstored<Select>{},
          Key{.range = kIndices,
              .text = text,
              .words = {"x0", "x1", "y0", "y1", "x0y0", "x1y0", "x0y1", "x1y1"},
              .shortest = 1,
              .longest = 100000000,
              .required = true});
}

}  // namespace detail

template <>
struct Fields<HandleSpec> {
  static constexpr const char* kText = "Particles of one piece that are held.";
  static void visit(auto&& visitor) {
    visitor("name", Unstored<std::string>{}, detail::name_key());
    detail::visit_selection<SelectKey>(visitor);
    visitor("motion", Unstored<MotionKey>{MotionKey{std::vector<Keyframe>{}}},
            Key{.text = "How they move; empty: held still. The first keyframe is the start itself",
                .longest = kKeyframes});
    visitor("release", &HandleSpec::release,
            Key{.unit = "s", .range = {0, 1e6}, .text = "When they are let go; left out: never"});
  }
};

template <>
struct Fields<WeightSpec> {
  static constexpr const char* kText = "Mass added to particles of one piece.";
  static void visit(auto&& visitor) {
    detail::visit_selection<RowKey>(visitor);
    visitor("mass", &WeightSpec::mass,
            Key{.unit = "kg",
                .range = {0, 1e6},
                .text = "Mass added to each of them",
                .required = true});
  }
};

template <>
struct Fields<SideKey> {
  static constexpr const char* kName = "side";
  static constexpr const char* kText = "One side of a seam.";
  static void visit(auto&& visitor) {
    detail::visit_selection<RowKey>(visitor, detail::row_text());
  }
};

template <>
struct Fields<SeamSpec> {
  static constexpr const char* kText =
      "Two rows of equally many particles, sewn first to first and last to last.";
  static void visit(auto&& visitor) {
    using T = SeamSpec;
    visitor("sides", Unstored<std::array<SideKey, 2>>{},
            Key{.text = "The two rows", .required = true});
    visitor("reverse", Unstored<bool>{false},
            Key{.text = "Whether the first particle of one side is sewn to the last of the other"});
    visit_within<SewingConfig>(&T::sewing, visitor);
    visitor("merge", &T::merge, detail::merge_key());
  }
};

template <>
struct Fields<WaterSource> {
  static constexpr const char* kText = "Water that drops onto particles of one piece.";
  static void visit(auto&& visitor) {
    using T = WaterSource;
    detail::visit_selection<SelectKey>(visitor);
    visitor("rate", &T::rate,
            Key{.unit = "kg/s",
                .range = {0, 1e6},
                .text = "Onto all of them together",
                .required = true});
    visitor("begin", &T::begin, Key{.unit = "s", .range = {0, 1e6}, .text = "When it begins"});
    visitor("end", &T::end, Key{.unit = "s", .range = {0, 1e6}, .text = "When it ends"});
    visitor("velocity", &T::velocity, Key{.unit = "m/s", .text = "Velocity of the drops"});
  }
};

template <>
struct Fields<WettingConfig> {
  static void visit(auto&& visitor) {
    using T = WettingConfig;
    visitor("diffusivity", &T::diffusivity,
            Key{.unit = "m²/s", .range = {0, 1}, .text = "Of water in the cloth"});
    visitor("saturation", &T::saturation,
            Key{.unit = "1",
                .range = {1e-6, 1000},
                .text = "Water that dry cloth holds by its mass; what is above drips"});
  }
};

template <>
struct Fields<WaterSpec> {
  static void visit(auto&& visitor) {
    visit_within<WettingConfig>(&WaterSpec::wetting, visitor);
    visitor("sources", &WaterSpec::sources,
            Key{.text = "Where water drops onto the cloth", .longest = 10000});
  }
};

// -- obstacles -----------------------------------------------------------------------------------

namespace detail {

inline Key length_key(const char* text) { return {.unit = "m", .range = kLength, .text = text}; }

void visit_resolution(auto&& visitor) {
  visitor("resolution", Unstored<int>{BodyShape{}.resolution},
          Key{.unit = "1", .range = {3, 1000}, .text = "Segments around the axis of its surface"});
}

}  // namespace detail

template <>
struct Fields<Plane> {
  static constexpr const char* kType = "plane";
  static constexpr const char* kText = "The plane z = 0, a square.";
  static void visit(auto&& visitor) {
    visitor("size", &Plane::size, detail::length_key("Side of the square"));
  }
};
template <>
struct Fields<Box> {
  static constexpr const char* kType = "box";
  static constexpr const char* kText = "A box.";
  static void visit(auto&& visitor) {
    visitor("size", &Box::size, detail::length_key("Full extents"));
  }
};
template <>
struct Fields<Sphere> {
  static constexpr const char* kType = "sphere";
  static constexpr const char* kText = "A sphere.";
  static void visit(auto&& visitor) {
    visitor("radius", &Sphere::radius, detail::length_key("Radius"));
    detail::visit_resolution(visitor);
  }
};
template <>
struct Fields<Capsule> {
  static constexpr const char* kType = "capsule";
  static constexpr const char* kText = "A cylinder with round ends.";
  static void visit(auto&& visitor) {
    visitor("radius", &Capsule::radius, detail::length_key("Radius"));
    visitor("height", &Capsule::length,
            detail::length_key("Height of the cylinder, without its ends"));
    detail::visit_resolution(visitor);
  }
};
template <>
struct Fields<Cylinder> {
  static constexpr const char* kType = "cylinder";
  static constexpr const char* kText = "A cylinder.";
  static void visit(auto&& visitor) {
    visitor("radius", &Cylinder::radius, detail::length_key("Radius"));
    visitor("height", &Cylinder::height, detail::length_key("Height"));
    detail::visit_resolution(visitor);
  }
};
template <>
struct Fields<Cone> {
  static constexpr const char* kType = "cone";
  static constexpr const char* kText = "A cone, tip up.";
  static void visit(auto&& visitor) {
    visitor("radius", &Cone::radius, detail::length_key("Radius of its base"));
    visitor("height", &Cone::height, detail::length_key("Height"));
    detail::visit_resolution(visitor);
  }
};
template <>
struct Fields<Torus> {
  static constexpr const char* kType = "torus";
  static constexpr const char* kText = "A ring in the xy-plane.";
  static void visit(auto&& visitor) {
    visitor("radius", &Torus::radius,
            detail::length_key("Radius of the circle in the middle of its tube"));
    visitor("tube", &Torus::tube, detail::length_key("Radius of its tube"));
    detail::visit_resolution(visitor);
  }
};

/// The keys that say how the files of a body are read.
template <>
struct Fields<LoadConfig> {
  static void visit(auto&& visitor) {
    using T = LoadConfig;
    visitor("unit", &T::unit,
            Key{.unit = "m",
                .range = {1e-9, 1e6},
                .text = "Metres per unit of the file; missing: what a glTF, Collada or FBX file "
                        "states, else 1"});
    visitor("up", &T::up,
            Key{.text = "Which axis of the file points up; missing: what a glTF, Collada or FBX "
                        "file states, else z",
                .words = {"x", "y", "z"}});
    visitor("groups", &T::groups,
            Key{.text = "Groups, objects or materials of an OBJ file that belong to the body; "
                        "empty: all",
                .longest = 10000});
  }
};

template <>
struct Fields<BodyShape> {
  static constexpr const char* kText = "A body of a simple shape.";
  static void visit(auto&& visitor) {
    visitor("shape", &BodyShape::shape,
            Key{.text = "A shape about the origin with axis z, and how finely its surface is "
                        "divided",
                .required = true});
  }
};

template <>
struct Fields<BodyFile> {
  static constexpr const char* kText = "A body from a mesh file.";
  static void visit(auto&& visitor) {
    visitor("mesh", Unstored<FileOrMesh>{},
            Key{.text = "OBJ, PLY, OFF, STL, glTF or what else assimp reads, path relative to the "
                        "scene file; or the mesh itself",
                .shortest = 1,
                .required = true});
    visit_within<LoadConfig>(&BodyFile::load, visitor);
    visitor("weld", Unstored<std::variant<bool, double>>{true},
            Key{.unit = "m",
                .range = {1e-9, 1},
                .text = "Whether vertices at exactly equal positions become one; or the distance "
                        "within which vertices become one, before the transformation. A run says "
                        "how many it joined"});
  }
};

template <>
struct Fields<SequenceKeys> {
  static void visit(auto&& visitor) {
    using T = SequenceKeys;
    visitor("files", Unstored<std::variant<std::string, std::vector<std::string>>>{},
            Key{.text = "Mesh files in order, or one name in which # stands for each digit of a "
                        "number, such as \"walk_####.obj\", which begins with the lowest "
                        "number. Paths relative to the scene file",
                .shortest = 2,
                .longest = 100000,
                .required = true});
    visitor("fps", &T::fps,
            Key{.unit = "1/s", .range = {1e-6, 100000}, .text = "Meshes per second"});
  }
};

template <>
struct Fields<BodySequence> {
  static constexpr const char* kText =
      "A body that changes its shape: a sequence of meshes with the same triangles.";
  static void visit(auto&& visitor) {
    visitor("sequence", Unstored<SequenceKeys>{},
            Key{.text = "The meshes and their times; linear in between", .required = true});
    visit_within<LoadConfig>(&BodySequence::load, visitor);
  }
};

template <class Shape>
struct Fields<BodyOf<Shape>> {
  static constexpr const char* kText = Fields<Shape>::kText;
  static void visit(auto&& visitor) {
    using T = BodyOf<Shape>;
    visitor("name", Unstored<std::string>{}, detail::name_key());
    visit_within<Shape>(&T::shape, visitor);
    visitor("transformation", FieldWithin{&T::body, &BodySpec::placement},
            Key{.text = "Where the body stands at the start"});
    if constexpr (!std::is_same_v<Shape, BodySequence>) {
      visitor("motion", Unstored<MotionKey>{MotionKey{std::vector<Keyframe>{}}},
              Key{.text = "How it moves; empty: not at all", .longest = kKeyframes});
      visitor("mass", FieldWithin{&T::solid, &SolidSpec::mass},
              Key{.unit = "kg",
                  .range = {0, 1e6},
                  .text = "The body moves as weight, cloth and other bodies push it; evenly within "
                          "its surface. 0: it moves as \"motion\" says",
                  .completed = false});
      visitor("slide", FieldWithin{&T::solid, &SolidSpec::slide},
              Key{.unit = "1",
                  .text = "With mass: the direction along which alone it moves; 0: any",
                  .completed = false});
      visitor("hinge", FieldWithin{&T::solid, &SolidSpec::hinge},
              Key{.unit = "m",
                  .text = "With mass: two points of the axis about which alone it turns; equal: "
                          "none",
                  .completed = false});
      visitor(
          "limits", FieldWithin{&T::solid, &SolidSpec::limits},
          Key{.unit = "m or degrees",
              .range = {-1e4, 1e4},
              .text = "With slide or hinge: the least and the largest way or right-handed angle "
                      "from the start; equal: none",
              .completed = false});
      visitor("damping", FieldWithin{&T::solid, &SolidSpec::damping},
              Key{.unit = "N·s/m or N·m·s",
                  .range = {0, 1e6},
                  .text = "With slide or hinge: force or moment by the rate of the way or angle",
                  .completed = false});
      visitor("force", FieldWithin{&T::solid, &SolidSpec::force},
              Key{.unit = "N",
                  .text = "With mass: a constant force at its centre of mass",
                  .completed = false});
    }
    visitor(
        "friction", FieldWithin{&T::body, &BodySpec::friction},
        Key{.unit = "1", .range = kFriction, .text = "Coulomb coefficient of cloth on this body"});
  }
};

// -- the scene -----------------------------------------------------------------------------------

template <>
struct Fields<Scene> {
  static void visit(auto&& visitor) {
    using T = Scene;
    visitor("$schema", Unstored<std::string>{},
            Key{.text = "Path or address of this schema, so that editors complete and check the "
                        "file"});
    visitor("name", Unstored<std::string>{},
            Key{.text = "Name of the scene; by default the name of the file without its extension",
                .shortest = 1});
    visitor("description", Unstored<std::string>{""},
            Key{.text = "What the scene shows; not interpreted"});
    visitor("gravity", &T::gravity, Key{.unit = "m/s²", .text = "Acceleration by gravity"});
    visitor("geometry", Unstored<std::vector<PieceKey>>{},
            Key{.text = "The pieces of cloth: a grid made here (rectangular or triangular "
                        "pattern), any triangle mesh from a file, or the panels of a sewing "
                        "pattern",
                .shortest = 1,
                .longest = 1000,
                .required = true});
    visitor("materials", detail::empty_by_default<std::map<std::string, MaterialKeys>>(),
            Key{.text = "Fabrics by name. A piece without a material takes \"default\", which may "
                        "be redefined here"});
    visitor("force_laws", Unstored<ForceLawOptions>{},
            Key{.text = "Options of force laws, by the name of the law: {\"my_law\": "
                        "{\"my_option\": 2}}. Every law acts, named here or not. The laws of the "
                        "library have no options: their constants are those of the material"});
    visitor(
        "handles", &T::handles,
        Key{.text = "Particles of the cloth that are held, and how they move", .longest = 10000});
    visitor("weights", &T::weights,
            Key{.text = "Mass added to particles: a button, a heavy hem", .longest = 10000});
    visitor("seams", &T::seams,
            Key{.text = "Rows of particles that are sewn together", .longest = 10000});
    visitor("water", &T::water,
            Key{.text = "Water that spreads in the cloth and makes it heavier; left out: all stays "
                        "dry"});
    visitor("obstacles", detail::empty_by_default<std::vector<ObstacleKey>>(),
            Key{.text = "The bodies on which cloth falls: shapes, meshes, or sequences of meshes",
                .longest = 1000});
    visitor("motions", detail::empty_by_default<std::map<std::string, std::vector<Keyframe>>>(),
            Key{.text = "Motions by name, for handles and obstacles", .longest = kKeyframes});
    visitor("air", &T::air, Key{.text = "Air around the cloth"});
    visitor("perturbation", &T::perturbation,
            Key{.text = "Random velocities of the particles at the start: another seed gives "
                        "chaotic motion another course"});
    visitor("time", &T::time, Key{.text = "How long and how finely"});
    visitor("contact", &T::contact,
            Key{.text = "Collision between cloth and bodies and of cloth with itself"});
    visitor("solver", &T::solver, Key{.text = "How the motion is integrated"});
    visitor("plan", FieldWithin{&T::plan, &PlanSpec::proofs},
            Key{.text = "Leave out what provably does nothing; the results are the same to the "
                        "bit"});
    visitor("closed_form", &T::closed_form,
            Key{.text = "A motion that is known in closed form; `selvedge compare` measures errors "
                        "against it. free_fall: as a point in vacuum; incline: down the only "
                        "obstacle, which is flat, with its Coulomb friction",
                .words = {"", "free_fall", "incline"},
                .completed = false});
    visitor("output", &T::output,
            Key{.text = "What is written beside frames, checkpoint and result.json"});
  }
};

}  // namespace selvedge
