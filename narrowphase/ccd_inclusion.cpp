// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_methods.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/per_query.h>
#include <selvedge/narrowphase/detail/relative_query.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

// Finds roots of the vector function F(t, u, v), the difference of two points of the primitives at
// time t, by subdivision of the parameter box: [Snyder1992], for collisions [Redon2002], with
// inclusion boxes spanned by the corners and a bound of all rounding errors [Wang2021].
//
//   point-triangle  F = (1-u-v) x1(t) + u x2(t) + v x3(t) - x0(t),  u, v >= 0, u + v <= 1
//   edge-edge       F = (1-u) x0(t) + u x1(t) - (1-v) x2(t) - v x3(t)
//
// F is linear in each single parameter, so its values on a box of parameters lie in the hull of its
// values at the eight corners, and so in their bounding box. If this bounding box, widened by the
// rounding error, does not contain 0, the parameter box has no contact and is dropped. Otherwise
// the parameter box is halved along the parameter that moves F most, until its bounding box is
// narrower than the tolerance; then it counts as a contact. Hence nothing is missed. The reported
// time is the start of a box that is not proven free, and all earlier times are proven free, so it
// is not later than the true time.
//
// Rounding error of a corner, per coordinate in units of u, for vertices in the form of
// RelativeQuery with coordinates of at most 1. Parameters are multiples of 2^-kDeepest in [0, 1],
// so that they, 1 - t, 1 - u - v and 1 - v are exact. A vertex at t is off by 1 (input), 1 (two
// products whose factors have the sum 1) and 1 (sum): 3. The weights of a corner have the absolute
// sum 3 at most (u = v = 1 of point-triangle: -1, 1, 1): 3 * 3 from the vertices, 3 from the
// products, 2 + 3 from the sums: 17. With a reserve for terms in u^2 and underflow: kCornerError.
//
// Deviations from [Wang2021]: the bound uses coordinates relative to the first vertex instead of
// the largest world coordinate; boxes are ordered by time unless the configuration asks for breadth
// first; the tolerance is relative to the query's size; the budget counts boxes.

namespace selvedge {
namespace {

using detail::RelativeQuery;

constexpr double kCornerError = 20.0 * detail::kRoundoff;
/// The smallest tolerance. F moves by at most 2 along a parameter. Once this times the width is
/// below a fifth of the tolerance for each parameter, the box is narrower than the tolerance (time
/// counts three times, with weights of sum 3). So no width falls below 2^-40 / (5 * 2) / 2 >
/// 2^-kDeepest.
constexpr double kLeastTolerance = 0x1p-40;
constexpr int kDeepest = 45;
constexpr double kLeastWidth = 0x1p-45;

/// The parameters from lo to lo + width: t, u, v.
struct ParameterBox {
  std::array<double, 3> lo{0.0, 0.0, 0.0}, width{1.0, 1.0, 1.0};
  int halvings = 0;

  double time() const { return lo[0]; }
};

/// Orders a heap whose top is the next box to be examined. The order is total, because the search
/// stops after a number of boxes: equal boxes would leave the choice to the heap.
struct Later {
  CcdInclusionConfig::Order order;
  bool operator()(const ParameterBox& a, const ParameterBox& b) const {
    if (order == CcdInclusionConfig::Order::breadth_first)
      return std::tie(a.halvings, a.lo, a.width) > std::tie(b.halvings, b.lo, b.width);
    if (a.time() != b.time()) return a.time() > b.time();
    if (a.halvings != b.halvings) return a.halvings < b.halvings;
    return std::tie(a.lo, a.width) > std::tie(b.lo, b.width);
  }
};

class Subdivision {
 public:
  Subdivision(const RelativeQuery& query, const CcdInclusionConfig& config, double separation)
      : query_(query), config_(config), reach_(kCornerError + separation) {
    const auto largest = [](const Vec3& v) { return v.cwiseAbs().maxCoeff(); };
    for (const auto* x : {&query.x_t0, &query.x_t1}) {
      const Vec3 first = query.edges ? (*x)[1] : (*x)[2] - (*x)[1];
      const Vec3 second = query.edges ? (*x)[3] - (*x)[2] : (*x)[3] - (*x)[1];
      speed_[1] = std::max(speed_[1], largest(first));
      speed_[2] = std::max(speed_[2], largest(second));
    }
    for (int k = 1; k < 4; ++k)
      speed_[0] = std::max(speed_[0], largest(query.x_t1[k] - query.x_t0[k]));
  }

  double time() {
    push({});
    for (int seen = 0; !heap_.empty(); ++seen) {
      if (seen == config_.max_boxes) return earliest_left();
      std::pop_heap(heap_.begin(), heap_.end(), later_);
      const ParameterBox box = heap_.back();
      heap_.pop_back();
      if (box.time() < found_) halve(box);
    }
    return found_;
  }

 private:
  /// Keeps the box if it may hold a contact earlier than the known one.
  void push(const ParameterBox& box) {
    if (box.time() >= found_ || (!query_.edges && box.lo[1] + box.lo[2] > 1.0)) return;
    const double width = contact_width(box);
    if (width < 0.0) return;
    if (width <= config_.tolerance) {
      found_ = box.time();
      return;
    }
    heap_.push_back(box);
    std::push_heap(heap_.begin(), heap_.end(), later_);
  }

  void halve(const ParameterBox& box) {
    int along = -1;
    double most = -1.0;
    for (int i = 0; i < 3; ++i) {
      const double moved = speed_[i] * box.width[i];
      if (moved > most && box.width[i] > kLeastWidth) most = moved, along = i;
    }
    // By the choice of kDeepest the box was narrow before this point; if not, it counts as a
    // contact.
    if (along < 0) {
      found_ = box.time();
      return;
    }
    ParameterBox half = box;
    ++half.halvings;
    half.width[along] *= 0.5;
    push(half);
    half.lo[along] += half.width[along];
    push(half);
  }

  /// Largest side of the bounding box of F's corners, or -1 if that is farther from 0 than reach_.
  double contact_width(const ParameterBox& box) const {
    Vec3 lo = Vec3::Constant(kNoCollision), hi = -lo;
    for (const double t : {box.lo[0], box.lo[0] + box.width[0]}) {
      const auto x = detail::places(query_, t);
      for (const double u : {box.lo[1], box.lo[1] + box.width[1]}) {
        for (const double v : {box.lo[2], box.lo[2] + box.width[2]}) {
          const Vec3 f = query_.edges ? Vec3(u * x[1] - ((1.0 - v) * x[2] + v * x[3]))
                                      : Vec3((1.0 - u - v) * x[1] + u * x[2] + v * x[3]);
          lo = lo.cwiseMin(f);
          hi = hi.cwiseMax(f);
        }
      }
    }
    if (lo.maxCoeff() > reach_ || hi.minCoeff() < -reach_) return -1.0;
    return (hi - lo).maxCoeff();
  }

  /// Contacts can only be at or after this time: every parameter box that was dropped has none.
  double earliest_left() const {
    double earliest = found_;
    for (const ParameterBox& box : heap_) earliest = std::min(earliest, box.time());
    return earliest;
  }

  const RelativeQuery& query_;
  const CcdInclusionConfig& config_;
  double reach_;
  std::array<double, 3> speed_{0.0, 0.0, 0.0};  ///< distance that F moves along each parameter
  std::vector<ParameterBox> heap_;
  Later later_{config_.order};
  double found_ = kNoCollision;
};

class InclusionRule {
 public:
  explicit InclusionRule(const CcdInclusionConfig& config) : config_(config) {}

  double time(const Query& query) const {
    const RelativeQuery relative = detail::relative_query(query);
    if (relative.one_point) return 0.0;
    const double separation = detail::scaled_up(config_.min_separation, relative);
    return Subdivision(relative, config_, separation).time();
  }

  NarrowPhaseTraits traits() const {
    return {
        .misses_nothing = true,
        .source =
            "B. Wang, Z. Ferguson, T. Schneider, X. Jiang, M. Attene, D. Panozzo, A large-scale "
            "benchmark and an inclusion-based algorithm for continuous collision detection, "
            "2021; after J. M. Snyder, 1992, and S. Redon, A. Kheddar, S. Coquillart, 2002",
        .limits =
            "False alarms within the tolerance, and where the boxes run out; a separation is "
            "measured along the axes."};
  }

 private:
  CcdInclusionConfig config_;
};

void validate(const CcdInclusionConfig& config) {
  detail::require_separation(config.min_separation, "ccd_inclusion");
  if (!(config.tolerance >= kLeastTolerance && config.tolerance <= 1.0))
    throw std::invalid_argument(
        "ccd_inclusion: tolerance is " + std::to_string(config.tolerance) +
        "; it is a fraction of the query's size and must lie in [2^-40, 1]");
  if (config.max_boxes < 1)
    throw std::invalid_argument("ccd_inclusion: max_boxes is " + std::to_string(config.max_boxes) +
                                "; it must be 1 or more");
}

}  // namespace

std::unique_ptr<NarrowPhase> make_ccd_inclusion(const CcdInclusionConfig& config) {
  validate(config);
  return detail::per_query(InclusionRule(config));
}

std::unique_ptr<NarrowPhase> make_ccd_inclusion(const NarrowPhaseConfig& config) {
  CcdInclusionConfig own;
  own.tolerance = detail::tolerance_or(config, own.tolerance, "ccd_inclusion");
  own.min_separation = config.min_separation;
  return make_ccd_inclusion(own);
}

void register_ccd_inclusion(NarrowPhaseRegistry& registry) {
  const CcdInclusionConfig initial;
  registry.add("ccd_inclusion",
               {{.name = "tolerance",
                 .initial = initial.tolerance,
                 .unit = "1",
                 .least = kLeastTolerance,
                 .most = 1.0,
                 .meaning = "fraction of the query's size at which a parameter box counts as a "
                            "contact; smaller: fewer false alarms, more boxes"},
                detail::min_separation_option()},
               [](const MethodOptions& o) {
                 return make_ccd_inclusion(CcdInclusionConfig{
                     .tolerance = o["tolerance"], .min_separation = o["min_separation"]});
               });
}

}  // namespace selvedge
