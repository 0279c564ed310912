// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/compare/detail/compare_error.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/scene/build.h>
#include <selvedge/scene/internal/adaptive_cloth.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/simulation.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string_view>

namespace selvedge {
namespace {

constexpr int kLevels = 3;  // of a reference; the observed order requires three
/// Step length of the finest cell over that of the coarsest reference level.
constexpr double kFirstRefinement = 2.0;
/// Residual of the reference's linear solves.
constexpr const char* kReferenceTolerance = "1e-8";
constexpr std::size_t kHashDigits = 8;

std::vector<Override> joined(std::vector<Override> a, const std::vector<Override>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// A path with "a.0.b" for "a[0].b".
std::string plain_path(std::string path) {
  std::replace(path.begin(), path.end(), '[', '.');
  std::erase(path, ']');
  return path;
}

/// Without the values that a later one of the same path replaces.
std::vector<Override> last_of_each(const std::vector<Override>& all) {
  std::vector<Override> kept;
  for (const Override& o : all) {
    std::erase_if(kept,
                  [&](const Override& k) { return plain_path(k.path) == plain_path(o.path); });
    kept.push_back(o);
  }
  return kept;
}

const CompareAxis* axis_named(const std::vector<CompareAxis>& axes, const std::string& name) {
  for (const CompareAxis& axis : axes)
    if (axis.name == name) return &axis;
  return nullptr;
}

double as_number(const std::string& text) {
  return finite_number(std::string_view(text).substr(0, text.find('x'))).value_or(0.0);
}

class Planner {
 public:
  Planner(const CompareRequest& request, const Methods& methods,
          const std::function<void(const std::string&)>& note)
      : request_(request), methods_(methods), note_(note), set_(request.set) {}

  PlannedCompare make() {
    base_ = read_scene(request_.scene, request_.set, methods_);
    if (request_.limits.seeds) prepare_seeds();
    ComparePlan& plan = planned_.plan;
    plan.name = base_.name;
    plan.command = request_.command;
    plan.scene = request_.scene;
    plan.axes = read_axes(request_.vary, methods_);
    for (CompareAxis& axis : plan.axes)
      if (axis.name == "dt")
        for (const std::string& sentence : round_steps(axis, base_)) note_(sentence);
    plan.limits = request_.limits;
    plan.repeats = request_.repeats;
    plan.error = std::string(detail::error_quantity(request_.error).name);
    plan.build = program_hash();
    for (const auto& values : design_cells(plan.axes, request_.design)) add_cell(values);
    refuse_if_none_can_run();
    add_reference();
    return std::move(planned_);
  }

 private:
  /// Ensembles need a perturbation, and shapes with the same vertices.
  void prepare_seeds() {
    if (!mesh_change(base_).empty())
      throw std::invalid_argument(
          "--seeds: cells that split and seams that merge change the mesh at other times with "
          "every "
          "seed, so there is no mean shape; use --vary perturbation.seed");
    if (base_.perturbation.speed == 0.0)
      set_.push_back({"perturbation.speed", fmt::format("{:g}", kSeedSpeed)});
  }

  void add_cell(const std::vector<std::string>& values) {
    ComparePlan& plan = planned_.plan;
    const auto overrides = last_of_each(joined(set_, cell_overrides(plan.axes, values, base_)));
    const Scene scene = read_scene(request_.scene, overrides, methods_);
    CompareCell cell;
    cell.values = values;
    for (const Override& o : overrides) cell.set.push_back(o.path + "=" + o.value);
    const std::string threads = axis_value(plan.axes, values, "threads");
    cell.threads = threads.empty() ? plan.limits.threads : static_cast<int>(as_number(threads));
    cell.id = fmt::format("{:04}_{}", plan.cells.size(),
                          text_hash(scene.json + threads).substr(0, kHashDigits));
    cell.impossible = why_impossible(scene);
    if (!cell.impossible.empty())
      note_(fmt::format("cannot run and is marked: {}: {}", label(values), cell.impossible));
    planned_.scene_of_id.emplace_back(cell.id, scene.json);
    plan.cells.push_back(std::move(cell));
  }

  std::string label(const std::vector<std::string>& values) const {
    std::string text;
    for (std::size_t a = 0; a < values.size(); ++a)
      text += (a == 0 ? "" : ", ") + planned_.plan.axes[a].name + "=" + values[a];
    return text.empty() ? "the scene" : text;
  }

  /// The reason why a scene cannot start; empty if it can.
  std::string why_impossible(const Scene& scene) const {
    try {
      const Simulation simulation(scene, build_scene(scene, methods_), methods_);
      return {};
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  }

  void refuse_if_none_can_run() const {
    const auto& cells = planned_.plan.cells;
    if (std::any_of(cells.begin(), cells.end(), [](const auto& c) { return c.impossible.empty(); }))
      return;
    throw std::invalid_argument("no cell can run; the first says: " + cells[0].impossible);
  }

  /// Detectors and threads have no step or mesh to refine. If a comparison varies only these, sets
  /// of pairs are the reference.
  bool has_something_to_refine() const {
    const std::set<std::string> exact = {"broad_phase", "contact.broad_phase", "narrow_phase",
                                         "contact.narrow_phase", "threads"};
    const auto& axes = planned_.plan.axes;
    return std::any_of(axes.begin(), axes.end(),
                       [&](const CompareAxis& a) { return !exact.contains(a.name); });
  }

  void add_reference() {
    ComparePlan& plan = planned_.plan;
    if (!request_.reference) return;
    if (base_.closed_form != ClosedForm::none) {
      if (plan.error != "position")
        throw std::invalid_argument(fmt::format(
            "--error {}: the closed form that the scene names gives positions only", plan.error));
      plan.reference = ReferenceKind::closed_form;
      return;
    }
    if (!has_something_to_refine()) return;
    plan.reference = ReferenceKind::converged;
    for (int level = 0; level < kLevels; ++level) add_level(level);
  }

  double finest_step() const {
    const CompareAxis* dt = axis_named(planned_.plan.axes, "dt");
    double finest = nominal_step(base_);
    if (dt != nullptr)
      for (const std::string& value : dt->values) finest = std::min(finest, as_number(value));
    return finest;
  }

  std::vector<Override> level_overrides(int level) const {
    const double refinement = kFirstRefinement * static_cast<double>(1 << level);
    auto overrides = joined(set_, step_overrides(base_, finest_step() / refinement));
    overrides.push_back({"solver.tolerance", kReferenceTolerance});
    if (const CompareAxis* mesh = axis_named(planned_.plan.axes, "mesh"))
      overrides = joined(overrides, finer_mesh(*mesh, level));
    return joined(overrides, request_.reference_set);
  }

  /// Half as many cells as the finest mesh of the comparison, as many, and twice as many.
  std::vector<Override> finer_mesh(const CompareAxis& axis, int level) const {
    const auto finest =
        *std::max_element(axis.values.begin(), axis.values.end(),
                          [](const auto& a, const auto& b) { return as_number(a) < as_number(b); });
    const auto refined = [&](const std::string& particles) {
      const double cells = (as_number(particles) - 1.0) * 0.5 * static_cast<double>(1 << level);
      return fmt::format("{:.0f}", std::max(1.0, std::ceil(cells)) + 1.0);
    };
    const auto cross = finest.find('x');
    std::string value = refined(finest.substr(0, cross));
    if (cross != std::string::npos) value += "x" + refined(finest.substr(cross + 1));
    return cell_overrides({{"mesh", {value}, true}}, {value}, base_);
  }

  void add_level(int level) {
    const Scene scene = read_scene(request_.scene, level_overrides(level), methods_);
    const std::string id = "reference_" + text_hash(scene.json).substr(0, kHashDigits);
    planned_.plan.levels.push_back(id);
    planned_.scene_of_id.emplace_back(id, scene.json);
  }

  const CompareRequest& request_;
  const Methods& methods_;
  const std::function<void(const std::string&)>& note_;
  std::vector<Override> set_;  // of all cells and levels
  Scene base_;
  PlannedCompare planned_;
};

}  // namespace

PlannedCompare plan_compare(const CompareRequest& request, const Methods& methods,
                            const std::function<void(const std::string&)>& note) {
  return Planner(request, methods, note).make();
}

}  // namespace selvedge
