// SPDX-License-Identifier: MIT
//
// Ties a particle to a weighted mean of others: the dense layer of bilayered meshes [KangCho2002;
// survey 2.4], which follows the sparse layer, and the surface of a weave, which follows its yarns.
// A spring of zero rest length holds it,
//   E = ½ k |d|²,  d = x - Σ w_k x_k,  Σ w_k = 1.
// That of a dense layer acts only in the layer's local iteration (following.cpp), beside a sparse
// layer that is held; as a force a tie yields by force/k. The forces -k d and w_k k d have zero sum
// and zero moment (Σ x_i × f_i = -d × k d = 0). Damping acts along d only, so the same holds for
// it.
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

namespace selvedge {
namespace {

template <int N>
class Ties {
 public:
  static constexpr int arity = N + 1;
  static constexpr const char* name = "tie";

  explicit Ties(std::span<const Tie<N>> ties) : ties_(ties.begin(), ties.end()) {
    for (std::size_t i = 0; i < ties.size(); ++i) {
      detail::require_number_of("stiffness", name, i, ties[i].stiffness, false);
      detail::require_number_of("damping", name, i, ties[i].damping);
      double sum = 0.0;
      for (const double w : ties[i].weight) sum += w;
      constexpr double rounding = 1e-12;
      if (!(std::abs(sum - 1.0) <= rounding))
        throw std::invalid_argument("weights of tie " + std::to_string(i) +
                                    " must have the sum 1, not " + std::to_string(sum));
    }
  }

  std::size_t size() const { return ties_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return ties_[e].v[k]; }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(ties_, order); }

  detail::ElementSample<arity> sample(std::size_t e, std::span<const Vec3> x) const {
    const Tie<N>& tie = ties_[e];
    // Computed from differences to the tied particle, so no digits are lost far from the origin.
    Vec3 d = Vec3::Zero();
    for (int k = 0; k < N; ++k) d += tie.weight[k] * (x[tie.v[0]] - x[tie.v[k + 1]]);
    const double length = d.norm();
    // At zero distance any direction will do: the stiffness is isotropic.
    const Vec3 u = length > 0.0 ? Vec3(d / length) : Vec3::UnitX();
    detail::ElementSample<arity> s;
    s.valid = true;
    s.energy = 0.5 * tie.stiffness * length * length;
    s.moment = tie.stiffness * length;
    s.slope = s.across = s.bound = tie.stiffness;
    s.damping = tie.stiffness * tie.damping;
    s.weight[0] = 1.0;
    for (int k = 0; k < N; ++k) s.weight[k + 1] = -tie.weight[k];
    for (int k = 0; k < arity; ++k) s.gradient[k] = s.weight[k] * u;
    s.plane = Mat3::Identity() - u * u.transpose();
    return s;
  }

 private:
  std::vector<Tie<N>> ties_;
};

}  // namespace

std::unique_ptr<Force> make_tie_force(std::span<const Tie<2>> ties, std::size_t particles) {
  return std::make_unique<detail::ElementForce<Ties<2>>>(Ties<2>(ties), particles);
}

std::unique_ptr<Force> make_tie_force(std::span<const Tie<4>> ties, std::size_t particles) {
  return std::make_unique<detail::ElementForce<Ties<4>>>(Ties<4>(ties), particles);
}

void register_tie(FabricLaws& laws) {
  laws.forces.add("tie", {},
                  [](const MethodOptions&, const ClothMesh& cloth) {
                    ForceList forces;
                    if (!cloth.layers.empty())
                      forces.push_back(make_tie_force(cloth.layers, cloth.mass.size()));
                    if (!cloth.yarn_ties.empty())
                      forces.push_back(make_tie_force(cloth.yarn_ties, cloth.mass.size()));
                    return forces;
                  },
                  {.promise = "minus the gradient of its energy; dense layers and weaves",
                   .source = "Kang, Cho, 2002"});
}

}  // namespace selvedge
