// SPDX-License-Identifier: MIT
#include <selvedge/core/solver/detail/runge_kutta.h>
#include <selvedge/core/solver/detail/stability.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::size_t kStageGrain = 4096;

}  // namespace

RungeKuttaStages::RungeKuttaStages(const Tableau& tableau, std::size_t particles)
    : tableau_(tableau), x_(particles) {
  for (int i = 0; i < tableau.stages; ++i) {
    kx_[i].resize(particles);
    kv_[i].resize(particles);
  }
}

void RungeKuttaStages::evaluate(const ForceSum& forces, const Particles& particles,
                                std::span<const Vec3> x, std::span<const Vec3> v, double time,
                                double h) {
  for (int s = 0; s < tableau_.stages; ++s) {
    const auto& a = tableau_.a[s];
    parallel_for(x.size(), kStageGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Vec3 dx = Vec3::Zero(), dv = Vec3::Zero();
        for (int j = 0; j < s; ++j) {
          dx += a[j] * kx_[j][i];
          dv += a[j] * kv_[j][i];
        }
        x_[i] = x[i] + h * dx;
        kx_[s][i] = v[i] + h * dv;
      }
    });
    forces.accelerate({x_, kx_[s], particles.mass, time + tableau_.c[s] * h}, particles.inv_mass,
                      kv_[s]);
  }
}

void RungeKuttaStages::combine(std::span<const double> weights, std::span<Vec3> dx,
                               std::span<Vec3> dv) const {
  parallel_for(dx.size(), kStageGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      dx[i].setZero();
      dv[i].setZero();
      for (int s = 0; s < tableau_.stages; ++s) {
        dx[i] += weights[s] * kx_[s][i];
        dv[i] += weights[s] * kv_[s][i];
      }
    }
  });
}

Eigen::Matrix2d amplification_of(const Tableau& t, double theta, double delta) {
  const Eigen::Matrix2d z = mode_matrix(theta, delta);
  std::array<Eigen::Matrix2d, kMostStages> k;
  Eigen::Matrix2d end = Eigen::Matrix2d::Identity();
  for (int s = 0; s < t.stages; ++s) {
    Eigen::Matrix2d y = Eigen::Matrix2d::Identity();
    for (int j = 0; j < s; ++j) y += t.a[s][j] * k[j];
    k[s] = z * y;
    end += t.b[s] * k[s];
  }
  return end;
}

RungeKutta::RungeKutta(ForceList forces, std::size_t particles, const Tableau& tableau,
                       const IntegratorTraits& traits)
    : Integrator(std::move(forces), particles),
      traits_(traits),
      stages_(tableau, particles),
      v_(particles) {}

double RungeKutta::stable_step(const ModeBound& mode, double wanted) const {
  return stable_step_of(
      [&](double theta, double delta) { return amplification_of(stages_.tableau(), theta, delta); },
      mode, wanted);
}

void RungeKutta::begin(const StepStart& start, StepEnd end) {
  const Particles& p = start.particles;
  for (std::size_t i = 0; i < p.size(); ++i) v_[i] = p.inv_mass[i] > 0.0 ? p.v[i] : end.mean[i];
  stages_.evaluate(forces_, p, p.x, v_, start.time, start.h);
  stages_.combine(stages_.tableau().b, end.mean, end.v);
  for (std::size_t i = 0; i < p.size(); ++i) {
    end.v[i] = v_[i] + start.h * end.v[i];
    if (p.inv_mass[i] <= 0.0) end.mean[i] = v_[i];
  }
}

void add_runge_kutta(IntegratorRegistry& registry, const std::string& name, const Tableau& tableau,
                     const IntegratorTraits& traits) {
  registry.add(name, {},
               [tableau, traits](const MethodOptions&, ForceList forces, std::size_t particles,
                                 const ImplicitConfig&) {
                 return std::make_unique<RungeKutta>(std::move(forces), particles, tableau, traits);
               });
}

}  // namespace selvedge::detail
