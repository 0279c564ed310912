// SPDX-License-Identifier: MIT
//
// Bending of triangle meshes as a plate: ½ (θ-θ0)ᵀ W (θ-θ0) of the angles of all hinges, with the
// constant W of detail/shape_operator.cpp, which has the papers. The force of a hinge is that of
// [Bridson2003] with the moment W (θ-θ0 + damping·dθ/dt) instead of its own angle's.
//
// Jacobian: ∇θ W ∇θᵀ, without the curvature of θ itself, which is indefinite. Couples between
// hinges of two triangles would join vertices three rings apart. In the Jacobian they are replaced
// by what bounds them, |W_ef| on the diagonals of e and f: its blocks are those of the vertices of
// a triangle and its neighbours, and it is never softer than the force, so that steps stay stable.
// On grids without distortion these couples are small or none.
#include <selvedge/core/coloring.h>
#include <selvedge/core/detail/dihedral.h>
#include <selvedge/core/detail/force_checks.h>
#include <selvedge/core/force.h>

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <string>

namespace selvedge {
namespace {

constexpr std::size_t grain = 1024;

/// The hinges of one triangle, at most, with what of W the Jacobian has of them.
struct Patch {
  static constexpr int most_hinges = 3, most_vertices = 6;
  std::array<std::int32_t, most_hinges> hinge{-1, -1, -1};
  Mat3 couples = Mat3::Zero();
  std::array<std::int32_t, most_vertices> v;  ///< the last one repeated where there are fewer
  /// Place in `v` of each hinge's vertices.
  std::array<std::array<std::int8_t, 4>, most_hinges> place{};
  int hinges = 0, vertices = 0;
};

void validate(std::span<const Hinge> hinges, std::span<const HingeCouple> couples,
              std::size_t particles) {
  for (std::size_t i = 0; i < hinges.size(); ++i) {
    for (const std::int32_t v : hinges[i].v) detail::require_particle("hinge", i, v, particles);
    detail::require_number_of("stiffness", "hinge", i, hinges[i].stiffness);
    detail::require_number_of("damping", "hinge", i, hinges[i].damping);
    detail::require_number_of("size of rest_angle", "hinge", i, std::abs(hinges[i].rest_angle));
  }
  for (std::size_t i = 0; i < couples.size(); ++i) {
    const auto& [a, b, stiffness] = couples[i];
    detail::require_particle("couple", i, a, hinges.size());
    detail::require_particle("couple", i, b, hinges.size());
    detail::require_number_of("size of stiffness", "couple", i, std::abs(stiffness));
    if (a == b || hinges[a].damping != hinges[b].damping)
      throw std::invalid_argument("couple " + std::to_string(i) +
                                  " must join two hinges of the same damping");
  }
}

class ShapeOperatorForce final : public Force {
 public:
  ShapeOperatorForce(std::span<const Hinge> hinges, std::span<const HingeCouple> couples,
                     std::size_t particles) {
    validate(hinges, couples, particles);
    std::vector<std::int32_t> corners, number(hinges.size());
    for (const Hinge& h : hinges) corners.insert(corners.end(), h.v.begin(), h.v.end());
    Coloring coloring = color_elements(corners, 4, particles);
    for (const std::int32_t i : coloring.order) {
      number[i] = static_cast<std::int32_t>(hinges_.size());
      hinges_.push_back(hinges[i]);
    }
    color_begin_ = std::move(coloring.color_begin);
    std::vector<HingeCouple> own(couples.begin(), couples.end());
    for (HingeCouple& c : own) c = {number[c.a], number[c.b], c.stiffness};
    set_rows(own);
    set_patches(own, particles);
    bends_.resize(hinges_.size());
    off_.resize(hinges_.size());
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    measure(state.x, [&](std::size_t e, const detail::Dihedral& d) {
      double rate = 0.0;
      for (int k = 0; k < 4; ++k) rate += d.gradient[k].dot(state.v[hinges_[e].v[k]]);
      return hinges_[e].damping * rate;
    });
    for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        const double moment = moment_of(e);
        for (int k = 0; k < 4; ++k) f[hinges_[e].v[k]] -= moment * bends_[e].gradient[k];
      }
    });
  }

  double energy(const ForceState& state) const override {
    measure(state.x, [](std::size_t, const detail::Dihedral&) { return 0.0; });
    return parallel_sum(hinges_.size(), grain, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t e = begin; e < end; ++e) sum += 0.5 * off_[e] * moment_of(e);
      return sum;
    });
  }

  void add_links(std::vector<Edge>& links) const override {
    for (const Patch& p : patches_)
      for (int i = 0; i < p.vertices; ++i)
        for (int j = 0; j < i; ++j) links.push_back({p.v[i], p.v[j]});
  }

  void bind(const BlockMatrix& matrix) override {
    constexpr int n = Patch::most_vertices;
    slots_.assign(patches_.size(), {});
    for (std::size_t p = 0; p < patches_.size(); ++p)
      for (int i = 0; i < patches_[p].vertices; ++i)
        for (int j = 0; j < patches_[p].vertices; ++j)
          slots_[p][n * i + j] = matrix.slot(patches_[p].v[i], patches_[p].v[j]);
  }

  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    measure(state.x, [](std::size_t, const detail::Dihedral&) { return 0.0; });
    const std::span<Mat3> values = a.values();
    for_each_color(patch_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) add_patch(p, h, values);
    });
  }

  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                           std::span<double> damping) const override {
    measure(state.x, [](std::size_t, const detail::Dihedral&) { return 0.0; });
    for (std::size_t e = 0; e < hinges_.size(); ++e) {
      off_[e] = 0.0;
      for (const Vec3& g : bends_[e].gradient) off_[e] += g.norm();
    }
    for (std::size_t e = 0; e < hinges_.size(); ++e) {
      double sum = 0.0;
      for (std::int32_t k = row_begin_[e]; k < row_begin_[e + 1]; ++k)
        sum += std::abs(value_[k]) * off_[column_[k]];
      for (int k = 0; k < 4; ++k) {
        const double row = sum * bends_[e].gradient[k].norm();
        stiffness[hinges_[e].v[k]] += row;
        damping[hinges_[e].v[k]] += hinges_[e].damping * row;
      }
    }
  }

 private:
  /// W by rows.
  void set_rows(const std::vector<HingeCouple>& couples) {
    std::vector<std::int32_t> count(hinges_.size() + 1, 1);
    for (const HingeCouple& c : couples) {
      ++count[c.a];
      ++count[c.b];
    }
    row_begin_.assign(hinges_.size() + 1, 0);
    for (std::size_t e = 0; e < hinges_.size(); ++e) row_begin_[e + 1] = row_begin_[e] + count[e];
    column_.resize(row_begin_.back());
    value_.resize(row_begin_.back());
    std::vector<std::int32_t> next(row_begin_.begin(), row_begin_.end() - 1);
    const auto add = [&](std::int32_t row, std::int32_t column, double value) {
      column_[next[row]] = column;
      value_[next[row]++] = value;
    };
    for (std::size_t e = 0; e < hinges_.size(); ++e)
      add(static_cast<std::int32_t>(e), static_cast<std::int32_t>(e), hinges_[e].stiffness);
    for (const HingeCouple& c : couples) {
      add(c.a, c.b, c.stiffness);
      add(c.b, c.a, c.stiffness);
    }
  }

  /// The vertices that two hinges share; those of one triangle share it.
  std::vector<std::int32_t> shared(std::int32_t a, std::int32_t b) const {
    std::vector<std::int32_t> common;
    for (const std::int32_t v : hinges_[a].v)
      if (std::find(hinges_[b].v.begin(), hinges_[b].v.end(), v) != hinges_[b].v.end())
        common.push_back(v);
    std::sort(common.begin(), common.end());
    return common;
  }

  void set_patches(const std::vector<HingeCouple>& couples, std::size_t particles) {
    std::vector<double> diagonal;
    for (const Hinge& h : hinges_) diagonal.push_back(h.stiffness);
    std::map<std::vector<std::int32_t>, Patch> of_triangle;
    for (const HingeCouple& c : couples) {
      const std::vector<std::int32_t> common = shared(c.a, c.b);
      Patch* patch = common.size() == 3 ? &of_triangle[common] : nullptr;
      const int i = patch == nullptr ? -1 : place_in(*patch, c.a);
      const int j = patch == nullptr ? -1 : place_in(*patch, c.b);
      if (i < 0 || j < 0) {
        diagonal[c.a] += std::abs(c.stiffness);
        diagonal[c.b] += std::abs(c.stiffness);
      } else {
        patch->couples(i, j) = patch->couples(j, i) = c.stiffness;
      }
    }
    std::vector<Patch> patches;
    for (const auto& [triangle, patch] : of_triangle) patches.push_back(patch);
    give_diagonals(diagonal, patches);
    sort_patches(std::move(patches), particles);
  }

  static int place_in(Patch& patch, std::int32_t hinge) {
    for (int i = 0; i < patch.hinges; ++i)
      if (patch.hinge[i] == hinge) return i;
    if (patch.hinges == Patch::most_hinges) return -1;
    patch.hinge[patch.hinges] = hinge;
    return patch.hinges++;
  }

  void give_diagonals(const std::vector<double>& diagonal, std::vector<Patch>& patches) const {
    std::vector<char> given(hinges_.size(), 0);
    for (Patch& p : patches)
      for (int i = 0; i < p.hinges; ++i) {
        if (given[p.hinge[i]] != 0) continue;
        given[p.hinge[i]] = 1;
        p.couples(i, i) = diagonal[p.hinge[i]];
      }
    for (std::size_t e = 0; e < hinges_.size(); ++e) {
      if (given[e] != 0) continue;
      Patch& p = patches.emplace_back();
      p.hinge[p.hinges++] = static_cast<std::int32_t>(e);
      p.couples(0, 0) = diagonal[e];
    }
    for (Patch& p : patches) set_vertices(p);
  }

  void set_vertices(Patch& p) const {
    for (int i = 0; i < p.hinges; ++i)
      for (int k = 0; k < 4; ++k) {
        const std::int32_t v = hinges_[p.hinge[i]].v[k];
        const auto end = p.v.begin() + p.vertices, at = std::find(p.v.begin(), end, v);
        p.place[i][k] = static_cast<std::int8_t>(at - p.v.begin());
        if (at == end) p.v[p.vertices++] = v;
      }
    std::fill(p.v.begin() + p.vertices, p.v.end(), p.v[0]);
  }

  void sort_patches(std::vector<Patch> patches, std::size_t particles) {
    std::stable_sort(patches.begin(), patches.end(), [](const Patch& a, const Patch& b) {
      return a.hinge[0] < b.hinge[0];  // neighbours in memory are neighbours on the cloth
    });
    std::vector<std::int32_t> corners;
    for (const Patch& p : patches) corners.insert(corners.end(), p.v.begin(), p.v.end());
    Coloring coloring = color_elements(corners, Patch::most_vertices, particles);
    for (const std::int32_t i : coloring.order) patches_.push_back(patches[i]);
    patch_begin_ = std::move(coloring.color_begin);
  }

  /// Angles and gradients of all hinges at `x`; off_ = θ - θ0 + more(hinge).
  template <class More>
  void measure(std::span<const Vec3> x, const More& more) const {
    parallel_for(hinges_.size(), grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        detail::Dihedral& d = bends_[e];
        d = detail::dihedral(x, hinges_[e].v);
        off_[e] = 0.0;
        if (d.valid)
          off_[e] =
              std::remainder(d.angle - hinges_[e].rest_angle, 2.0 * std::numbers::pi) + more(e, d);
        else
          d.gradient.fill(Vec3::Zero());
      }
    });
  }

  double moment_of(std::size_t e) const {
    double sum = 0.0;
    for (std::int32_t k = row_begin_[e]; k < row_begin_[e + 1]; ++k)
      sum += value_[k] * off_[column_[k]];
    return sum;
  }

  void add_patch(std::size_t number, double h, std::span<Mat3> values) const {
    constexpr int n = Patch::most_vertices;
    const Patch& p = patches_[number];
    // Gradients of the hinges at the vertices of the patch, and the same times h (h + damping) W.
    std::array<Mat3, n> gradient, force;
    for (int i = 0; i < p.vertices; ++i) gradient[i].setZero();
    for (int a = 0; a < p.hinges; ++a)
      for (int k = 0; k < 4; ++k) gradient[p.place[a][k]].col(a) += bends_[p.hinge[a]].gradient[k];
    const double scale = h * (h + hinges_[p.hinge[0]].damping);
    for (int i = 0; i < p.vertices; ++i) force[i] = gradient[i] * (scale * p.couples);
    for (int i = 0; i < p.vertices; ++i)
      for (int j = 0; j < p.vertices; ++j)
        values[slots_[number][n * i + j]] += force[i] * gradient[j].transpose();
  }

  std::vector<Hinge> hinges_;
  std::vector<std::int32_t> row_begin_, column_;  ///< W, the diagonal first in each row
  std::vector<double> value_;
  std::vector<Patch> patches_;
  std::vector<std::array<std::int32_t, Patch::most_vertices * Patch::most_vertices>> slots_;
  std::vector<std::size_t> color_begin_, patch_begin_;
  mutable std::vector<detail::Dihedral> bends_;  ///< scratch of one evaluation
  mutable std::vector<double> off_;
};

}  // namespace

std::unique_ptr<Force> make_shape_operator_force(std::span<const Hinge> hinges,
                                                 std::span<const HingeCouple> couples,
                                                 std::size_t particles) {
  return std::make_unique<ShapeOperatorForce>(hinges, couples, particles);
}

}  // namespace selvedge
