// SPDX-License-Identifier: MIT
//
// Position correction after F. Durupinar, U. Gudukbay, "A virtual garment design and simulation
// system", 2007 [DurupinarGudukbay2007; survey eq. 50], and A. Fuhrmann, C. Gross, V. Luckas,
// "Interactive animation of cloth including self collision detection", WSCG 2003 [Fuhrmann2003;
// survey eq. 51]: a particle that ends at a distance d below the surface offset ξ is moved onto it,
//   x' = x + (ξ - d) n - min(μ (ξ - d)/|Δx_t|, 1) Δx_t,  Δx = x - x(t), Δx_t = Δx - n (Δx·n).
// Corrected: eq. 50 as printed offsets by a unit normal, one metre; eq. 51 mixes the distance d
// with a vector and omits the old position; its constant C_fric is replaced by Coulomb's bound.
// Pairs share the correction by their masses, and corrections are swept until they are consistent
// (contact_sweeps.h). The velocity is that of the corrected path [as in Verlet1967]. Leaving the
// velocity unchanged, as the survey's text may be read, lets the velocity of resting cloth grow by
// g h in every step. A correction of a gap that was too small at the start adds no velocity.
//
// Guarantee: momentum is kept and no kinetic energy is added. Work against weight and springs, as
// by lifting a particle onto the offset, is not counted here; the energy balance of a run counts
// it.
#include <selvedge/response/detail/contact_sweeps.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

class PositionCorrection final : public Response {
 public:
  void begin(const ResponseStep& step) override { answer_.begin(step); }
  void add(std::span<const ContactPoint> contacts) override { answer_.add(contacts); }
  void correct(std::span<Vec3> x_t1) override {
    answer_.take(x_t1, 0.0);
    answer_.hold_gaps();
    answer_.keep_impulses(answer_.h());
    answer_.follow_displacement();
    answer_.recover_gaps();
    answer_.give(x_t1);
  }
  void finish(std::span<Vec3> v) const override { answer_.finish(v); }
  void impulses(std::span<const Vec3>, std::vector<ContactImpulse>& out) const override {
    answer_.impulses(out);
  }
  ResponseTraits traits() const override {
    return {.promise =
                "particles end on the surface offset; correcting a gap adds no velocity; Coulomb "
                "friction; "
                "momentum is kept",
            .source =
                "Durupinar, Gudukbay, A virtual garment design and simulation system, 2007; "
                "Fuhrmann, Gross, Luckas, Interactive animation of cloth including self collision "
                "detection, 2003; survey eq. 50 and 51 corrected",
            .keeps_momentum = true,
            .passive = true};
  }

 private:
  ContactAnswer answer_;
};

}  // namespace
}  // namespace selvedge::detail

namespace selvedge {

void register_position_correction(ResponseRegistry& registry) {
  registry.add("position_correction", {},
               [](const MethodOptions&) { return std::make_unique<detail::PositionCorrection>(); });
}

}  // namespace selvedge
