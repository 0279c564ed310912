// SPDX-License-Identifier: MIT
//
// Identification of the springs of a net.
// - J. Louchet, X. Provot, D. Crochemore, "Evolutionary identification of cloth animation models",
//   1995 [Louchet1995]: stiffness, natural length and elongation rate of the springs for stretch,
//   shear and bending, found again from the motion of cloth that hangs by two corners.
// - G. Bianchi et al., "Simultaneous topology and stiffness identification for mass-spring models
//   based on FEM reference deformations", 2004 [Bianchi2004]: springs whose deformation is that of
//   finite elements. Here the stiffness of each kind of springs is unknown, not each single spring;
//   a kind whose stiffness falls to its lower bound is not needed.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/solver/integrator.h>
#include <selvedge/core/solver/strain_limiter.h>
#include <selvedge/lab/identify.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

constexpr std::array<const char*, 3> kKinds = {"stretch", "shear", "bend"};

std::vector<NetUnknown> all_net_unknowns() {
  // Bounds of nets of a few centimetres per cell; explicit steps of the trial are stable in them.
  constexpr std::array<std::array<double, 2>, 3> stiffness = {
      {{20.0, 500.0}, {5.0, 250.0}, {0.5, 50.0}}};
  std::vector<NetUnknown> all;
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    const std::string kind = kKinds[k];
    all.push_back(
        {kind + "_stiffness", k, &NetSprings::stiffness, stiffness[k][0], stiffness[k][1]});
    all.push_back({kind + "_length", k, &NetSprings::length, 0.8, 1.25});
    all.push_back({kind + "_limit", k, &NetSprings::limit, 0.01, 0.5});
  }
  return all;
}

/// 0 for the sides of a cell, 1 for its diagonals, 2 for springs across two cells.
std::size_t kind_of(const Spring& s, const GridConfig& grid) {
  const std::int32_t columns = grid.cells_x + 1;
  const std::int32_t di = std::abs(s.b % columns - s.a % columns),
                     dj = std::abs(s.b / columns - s.a / columns);
  return di == 1 && dj == 1 ? 1 : di + dj == 2 ? 2 : 0;
}

ClothMesh make_net(const NetTrial& trial, const NetKinds& kinds) {
  Material material;
  material.density = trial.density;
  material.spring_damping = trial.spring_damping;
  ClothMesh net =
      make_spring_net(SpringNet::rectangular, trial.grid,
                      {kinds[0].stiffness, kinds[1].stiffness, kinds[2].stiffness, true}, material);
  net.strain_limit.resize(net.springs.size());
  for (std::size_t s = 0; s < net.springs.size(); ++s) {
    const NetSprings& kind = kinds[kind_of(net.springs[s], trial.grid)];
    net.springs[s].rest_length *= kind.length;
    net.strain_limit[s] = kind.limit;
  }
  return net;
}

Particles held_particles(const NetTrial& trial, const GridConfig& grid, const ClothMesh& cloth) {
  const std::size_t n = cloth.mass.size();
  Particles p{cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  const std::int32_t columns = grid.cells_x + 1, rows = grid.cells_y + 1;
  for (std::int32_t i = 0; i < columns * rows; ++i) {
    const bool held = trial.by_side ? i % columns == 0 : i == 0 || i == columns - 1;
    p.inv_mass.push_back(held ? 0.0 : 1.0 / p.mass[i]);
  }
  return p;
}

/// Positions at equal times during the motion of a cloth under one acceleration.
class Motion {
 public:
  Motion(const NetTrial& trial, const GridConfig& grid, const ClothMesh& cloth, const Vec3& load)
      : trial_(trial), p_(held_particles(trial, grid, cloth)) {
    ForceList forces = make_internal_forces(cloth);
    forces.push_back(make_gravity(load));
    integrator_ = make_method_named(std::move(forces));
    if (!trial.limiter.empty())
      limiter_ = strain_limiters()
                     .at(trial.limiter)({}, cloth.springs, cloth.strain_limit, p_.size())
                     .method;
  }

  std::vector<Vec3> sampled() {
    std::vector<Vec3> samples;
    const auto steps = static_cast<int>(std::lround(trial_.duration / trial_.step));
    for (int k = 1; k <= steps; ++k) {
      step((k - 1) * trial_.step);
      if (k * trial_.samples / steps > (k - 1) * trial_.samples / steps)
        samples.insert(samples.end(), p_.x.begin(), p_.x.end());
    }
    return samples;
  }

 private:
  std::unique_ptr<Integrator> make_method_named(ForceList forces) const {
    const IntegratorRegistry all = integrators();
    if (const std::string fault = all.fault(trial_.integrator); !fault.empty())
      throw std::invalid_argument("identify: " + fault);
    constexpr ImplicitConfig solve{1e-8, 2000};
    return all.at(trial_.integrator)({}, std::move(forces), p_.size(), solve);
  }

  void step(double time) {
    const double h = trial_.step;
    std::vector<Vec3> mean = p_.v, end(p_.size(), Vec3::Zero());
    const bool ends_with_mean = integrator_->traits().ends_with_mean;
    integrator_->begin({p_, time, h}, {mean, end});
    integrator_->solve({}, {mean, end}, 1.0);
    std::vector<Vec3> x(p_.size());
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] = p_.inv_mass[i] > 0.0 ? Vec3(p_.x[i] + h * mean[i]) : p_.x[i];
    std::vector<Vec3> free = x;
    if (limiter_) limiter_->limit_ends({p_.x, p_.inv_mass, h}, x);
    // The velocity follows the correction of the position.
    for (std::size_t i = 0; i < x.size(); ++i)
      if (p_.inv_mass[i] > 0.0)
        p_.v[i] = (ends_with_mean ? mean[i] : end[i]) + (x[i] - free[i]) / h;
    p_.x = std::move(x);
    integrator_->accept({p_.x, p_.v, p_.mass, time + h});
  }

  const NetTrial& trial_;
  Particles p_;
  std::unique_ptr<Integrator> integrator_;
  std::unique_ptr<StrainLimitMethod> limiter_;
};

std::vector<Vec3> all_motions(const NetTrial& trial, const GridConfig& grid,
                              const ClothMesh& cloth) {
  std::vector<Vec3> all;
  for (const Vec3& load : trial.loads) {
    const std::vector<Vec3> one = Motion(trial, grid, cloth, load).sampled();
    all.insert(all.end(), one.begin(), one.end());
  }
  return all;
}

void validate_net_trial(const NetTrial& trial) {
  require(trial.step > 0.0 && std::isfinite(trial.step), "step", trial.step, "positive and finite");
  require(trial.duration >= trial.step, "duration", trial.duration, "at least one step");
  require(trial.samples >= 1, "samples", trial.samples, "at least 1");
  require(!trial.loads.empty(), "loads", 0, "at least one");
}

}  // namespace

NetTrial NetTrial::pulled() {
  NetTrial trial;
  trial.by_side = true;
  trial.loads = {{40.0, 0.0, 0.0}, {0.0, 40.0, 0.0}};
  trial.step = 1.0;  // implicit steps so long go to the rest shape
  trial.duration = 12.0;
  trial.samples = 1;
  trial.integrator = "implicit_newton";
  trial.limiter.clear();
  return trial;
}

NetTrial NetTrial::of_target() const {
  NetTrial target = *this;
  if (target.limiter == "position") target.limiter = "ordered_position";
  if (target.integrator == "implicit_newton") {
    target.integrator = "implicit_euler";
    return target;
  }
  constexpr double shorter = 4.0;
  target.integrator = "runge_kutta_4";
  target.step /= shorter;
  return target;
}

std::vector<NetUnknown> net_unknowns(const std::vector<std::string>& names) {
  std::vector<NetUnknown> chosen;
  const std::vector<NetUnknown> all = all_net_unknowns();
  for (const std::string& name : names) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const NetUnknown& u) { return u.name == name; });
    if (found == all.end())
      throw std::invalid_argument("identify: there is no constant \"" + name +
                                  "\" of a net; name stretch, shear or bend with _stiffness, "
                                  "_length or _limit");
    chosen.push_back(*found);
  }
  if (chosen.empty())
    throw std::invalid_argument("identify: name at least one constant to look for");
  return chosen;
}

std::vector<Vec3> net_motion(const NetTrial& trial, const NetKinds& kinds) {
  validate_net_trial(trial);
  return all_motions(trial, trial.grid, make_net(trial, kinds));
}

std::vector<Vec3> finite_element_motion(const NetTrial& trial, double stretch, double poisson,
                                        std::int32_t finer) {
  validate_net_trial(trial);
  require(finer >= 1, "finer", finer, "at least 1");
  GridConfig grid = trial.grid;
  grid.cells_x *= finer;
  grid.cells_y *= finer;
  Material material;
  material.density = trial.density;
  material.stretch_law = "st_venant_kirchhoff";
  material.stretch_stiffness = stretch;
  material.poisson = poisson;
  material.shear_stiffness = 0.5 * stretch / (1.0 + poisson);
  material.bending_stiffness = 0.0;
  NetTrial without = trial;
  without.limiter.clear();
  const std::vector<Vec3> fine = all_motions(without, grid, make_rectangular(grid, material));
  std::vector<Vec3> coarse;
  const std::size_t all = (grid.cells_x + std::size_t{1}) * (grid.cells_y + std::size_t{1});
  for (std::size_t first = 0; first < fine.size(); first += all)
    for (std::int32_t j = 0; j <= trial.grid.cells_y; ++j)
      for (std::int32_t i = 0; i <= trial.grid.cells_x; ++i)
        coarse.push_back(fine[first + static_cast<std::size_t>(finer) *
                                          (static_cast<std::size_t>(j) * (grid.cells_x + 1) + i)]);
  return coarse;
}

NetKinds NetSearch::at(const std::vector<double>& logs) const {
  NetKinds kinds = base;
  for (std::size_t k = 0; k < unknowns.size(); ++k)
    kinds[unknowns[k].kind].*(unknowns[k].field) = std::pow(10.0, logs[k]);
  return kinds;
}

double NetSearch::residual(const std::vector<double>& logs) const {
  const std::vector<Vec3> x = net_motion(trial, at(logs));
  if (x.size() != target.size())
    throw std::invalid_argument("identify: the target has " + std::to_string(target.size()) +
                                " positions, the net has " + std::to_string(x.size()));
  double square = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) square += (x[i] - target[i]).squaredNorm();
  constexpr double percent = 100.0, diverged = 1e6;
  const double rms = std::sqrt(square / static_cast<double>(x.size()));
  const double part = percent * rms / std::max(trial.grid.size_x, trial.grid.size_y);
  return std::isfinite(part) ? std::min(part, diverged) : diverged;
}

SearchSpace NetSearch::space() const {
  SearchSpace space;
  for (const NetUnknown& u : unknowns) {
    space.lowest.push_back(std::log10(u.lowest));
    space.highest.push_back(std::log10(u.highest));
  }
  space.residual = [this](const std::vector<double>& logs) { return residual(logs); };
  return space;
}

}  // namespace selvedge
