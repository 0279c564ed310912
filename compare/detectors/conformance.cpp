// SPDX-License-Identifier: MIT
#include <selvedge/compare/detectors/conformance.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

namespace selvedge {
namespace {

/// One call for all detectors, with the answer of brute force.
struct Call {
  SurfaceView a, b;
  bool self;
  bool b_is_closed, b_keeps_shape, is_beyond_float;
  std::string name;
  std::uint64_t seed;
  int step;
  bool with_all_threads;  ///< repeat the call with each number of threads
  CandidatePairs boxes = {}, touching = {};

  void ask(BroadPhase& detector, CandidatePairs& out) const {
    if (self)
      detector.find_self_pairs(a, out);
    else
      detector.find_pairs(a, b, out);
  }
};

bool same(const CandidatePairs& a, const CandidatePairs& b) {
  return a.point_triangle == b.point_triangle && a.triangle_point == b.triangle_point &&
         a.edge_edge == b.edge_edge;
}

template <class Pair>
void sort_and_drop_duplicates(std::vector<Pair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

CandidatePairs as_sets(CandidatePairs pairs) {
  sort_and_drop_duplicates(pairs.point_triangle);
  sort_and_drop_duplicates(pairs.triangle_point);
  sort_and_drop_duplicates(pairs.edge_edge);
  return pairs;
}

template <class Pair>
std::vector<Pair> difference(const std::vector<Pair>& a, const std::vector<Pair>& b) {
  std::vector<Pair> out;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
  return out;
}

/// The pairs of `a` that are not in `b`; both are sets.
CandidatePairs difference(const CandidatePairs& a, const CandidatePairs& b) {
  return {difference(a.point_triangle, b.point_triangle),
          difference(a.triangle_point, b.triangle_point), difference(a.edge_edge, b.edge_edge)};
}

bool is_sorted(const CandidatePairs& p) {
  return std::is_sorted(p.point_triangle.begin(), p.point_triangle.end()) &&
         std::is_sorted(p.triangle_point.begin(), p.triangle_point.end()) &&
         std::is_sorted(p.edge_edge.begin(), p.edge_edge.end());
}

/// About `most` pairs, evenly chosen from all lists.
CandidatePairs sample(const CandidatePairs& from, std::size_t most) {
  const std::size_t stride = from.size() / most + 1;
  const auto thin = [stride](const auto& all, auto& out) {
    for (std::size_t i = 0; i < all.size(); i += stride) out.push_back(all[i]);
  };
  CandidatePairs out;
  thin(from.point_triangle, out.point_triangle);
  thin(from.triangle_point, out.triangle_point);
  thin(from.edge_edge, out.edge_edge);
  return out;
}

std::string first_pair(const CandidatePairs& pairs) {
  const auto text = [](const char* first, std::int32_t i, const char* second, std::int32_t j) {
    return std::string(first) + std::to_string(i) + second + std::to_string(j);
  };
  if (!pairs.point_triangle.empty())
    return text("point ", pairs.point_triangle[0].point, " of the first, triangle ",
                pairs.point_triangle[0].triangle);
  if (!pairs.triangle_point.empty())
    return text("point ", pairs.triangle_point[0].point, " of the second, triangle ",
                pairs.triangle_point[0].triangle);
  if (!pairs.edge_edge.empty())
    return text("edge ", pairs.edge_edge[0].edge_a, ", edge ", pairs.edge_edge[0].edge_b);
  return "none";
}

bool contains(const Triangle& t, std::int32_t v) {
  return std::find(t.begin(), t.end(), v) != t.end();
}

bool share_vertex(const Edge& a, const Edge& b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

bool is_below(std::int32_t i, std::size_t n) { return i >= 0 && static_cast<std::size_t>(i) < n; }

/// The pairs that no detector may report for these surfaces.
CandidatePairs malformed_pairs(const Call& call, const CandidatePairs& pairs) {
  CandidatePairs out;
  const SurfaceView &a = call.a, &b = call.self ? call.a : call.b;
  for (const PointTrianglePair& p : pairs.point_triangle)
    if (!is_below(p.point, a.x_t0.size()) || !is_below(p.triangle, b.triangles.size()) ||
        (call.self && contains(a.triangles[p.triangle], p.point)))
      out.point_triangle.push_back(p);
  for (const PointTrianglePair& p : pairs.triangle_point)
    if (call.self || !is_below(p.point, b.x_t0.size()) || !is_below(p.triangle, a.triangles.size()))
      out.triangle_point.push_back(p);
  for (const EdgeEdgePair& p : pairs.edge_edge)
    if (!is_below(p.edge_a, a.edges.size()) || !is_below(p.edge_b, b.edges.size()) ||
        (call.self && (p.edge_a >= p.edge_b || share_vertex(a.edges[p.edge_a], a.edges[p.edge_b]))))
      out.edge_edge.push_back(p);
  return out;
}

/// A detector under test.
class Examinee {
 public:
  using Make = std::function<std::unique_ptr<BroadPhase>()>;

  Examinee(std::string name, Make make, const ConformanceConfig& config)
      : config_(config), make_(std::move(make)) {
    report_.detector = std::move(name);
    renew();
    report_.traits = detector_->traits();
  }

  void begin_scene(std::size_t number) {
    if (number % config_.scenes_per_detector == 0) renew();
    served_ = false;
  }

  void answer(const Call& call) {
    if (!serves(call) || !ask(*detector_, call, out_)) return;
    judge(call, out_);
    if (call.with_all_threads) compare_threads(call);
  }

  void check_budgets(const Call& call);
  void check_bad_input(const Call& good);

  bool needs_touching() const {
    return report_.traits.guarantee == Guarantee::approximate ||
           report_.traits.pairs == PairSet::culled;
  }
  ConformanceReport take_report() { return std::move(report_); }

 private:
  void renew() {
    detector_ = make_();
    by_threads_.clear();
    for (std::size_t i = 0; i < config_.threads.size(); ++i) by_threads_.push_back(make_());
  }

  bool serves(const Call& call) const {
    const BroadPhaseTraits& t = report_.traits;
    if (call.self) return t.self && t.deforming && !t.closed_body_only;
    return (t.deforming || call.b_keeps_shape) && (!t.closed_body_only || call.b_is_closed);
  }

  /// Records `count` faults of one kind; the first with a description.
  template <class Count>
  void note(Count& counter, std::size_t count, const char* kind, const Call& call,
            const std::string& detail) {
    counter += count;
    if (count > 0 && kinds_noted_.insert(kind).second)
      report_.faults.push_back(
          {call.seed, call.step, std::string(kind) + ": " + call.name + "; " + detail});
  }

  /// Returns false if there is no answer to judge.
  bool ask(BroadPhase& detector, const Call& call, CandidatePairs& out) {
    try {
      call.ask(detector, out);
    } catch (const std::invalid_argument& error) {
      if (call.is_beyond_float)
        ++report_.refused;
      else
        note(report_.failed, 1, "a good surface refused", call, error.what());
      return false;
    } catch (const std::exception& error) {
      note(report_.failed, 1, "failed", call, error.what());
      return false;
    }
    return true;
  }

  void judge(const Call& call, const CandidatePairs& out) {
    ++report_.calls;
    if (!served_) ++report_.scenes;
    served_ = true;
    report_.pairs += out.size();
    if (same(out, call.boxes)) {  // The usual case: nothing to analyse.
      report_.boxes += out.size();
      report_.boxes_found += out.size();
      report_.touching += call.touching.size();
      report_.touching_found += call.touching.size();
      return;
    }
    note(report_.unsorted, !is_sorted(out), "not sorted", call, "");
    const CandidatePairs wrong = malformed_pairs(call, out);
    note(report_.malformed, wrong.size(), "a pair that may not be", call, first_pair(wrong));
    const CandidatePairs found = as_sets(out);
    note(report_.duplicates, out.size() - found.size(), "duplicates", call,
         std::to_string(out.size() - found.size()) + " of them");
    compare(call, found);
  }

  void compare(const Call& call, const CandidatePairs& found) {
    const CandidatePairs no_boxes = difference(call.boxes, found);
    const CandidatePairs no_touching = difference(call.touching, found);
    const CandidatePairs beyond = difference(found, call.boxes);
    report_.boxes += call.boxes.size();
    report_.boxes_found += call.boxes.size() - no_boxes.size();
    report_.touching += call.touching.size();
    report_.touching_found += call.touching.size() - no_touching.size();
    report_.beyond += beyond.size();
    if (report_.traits.guarantee == Guarantee::approximate) return;
    const CandidatePairs& lost = report_.traits.pairs == PairSet::culled ? no_touching : no_boxes;
    note(report_.lost, lost.size(), "lost", call,
         std::to_string(lost.size()) + " of them, first " + first_pair(lost));
    std::size_t in_faults = 0;  // These are already counted in `beyond`.
    if (report_.traits.pairs == PairSet::boxes)
      note(in_faults, beyond.size(), "boxes that do not overlap", call, first_pair(beyond));
  }

  /// These detectors have received the same calls, so they must agree even in the pairs that they
  /// cull.
  void compare_threads(const Call& call) {
    bool has_first = false;
    for (std::size_t i = 0; i < config_.threads.size(); ++i) {
      const ThreadLimit limit(config_.threads[i]);
      if (!ask(*by_threads_[i], call, has_first ? other_out_ : out_)) continue;
      if (has_first)
        note(report_.thread_dependent, !same(out_, other_out_), "depends on the threads", call,
             "another list with " + std::to_string(config_.threads[i]));
      has_first = true;
    }
  }

  /// Checks that a call with this budget ends correctly, and that the detector still works
  /// afterwards.
  void expect_over_budget(const Call& call, const PairBudget& budget, const CandidatePairs& right) {
    detector_->set_budget(budget);
    CandidatePairs out = right;
    std::string fault = "answered with " + std::to_string(right.size()) + " pairs on a budget of " +
                        std::to_string(budget.pairs) + " and " + std::to_string(budget.bytes) +
                        " bytes";
    try {
      call.ask(*detector_, out);
    } catch (const BudgetExceeded&) {
      fault = out.size() == 0 ? "" : "left pairs in the list";
    } catch (const std::exception& error) {
      fault = std::string("threw '") + error.what() + "' instead of BudgetExceeded";
    }
    detector_->set_budget({});
    note(report_.budget_faults, !fault.empty(), "budget", call, fault);
    if (CandidatePairs again; ask(*detector_, call, again))
      note(report_.budget_faults, !same(again, right), "other pairs after a budget", call, "");
  }

  /// The detector must reject `call` with `word` in the message, and then answer `good` as before.
  void expect_refusal(const Call& call, const std::string& word, const Call& good,
                      const CandidatePairs& right) {
    std::string fault = "not refused";
    try {
      CandidatePairs out;
      call.ask(*detector_, out);
    } catch (const std::invalid_argument& error) {
      const bool named = std::string(error.what()).find(word) != std::string::npos;
      fault = named ? "" : std::string("'") + error.what() + "' does not say '" + word + "'";
    } catch (const std::exception& error) {
      fault = std::string("threw '") + error.what() + "' instead of std::invalid_argument";
    }
    note(report_.input_faults, !fault.empty(), "bad input", call, fault);
    if (CandidatePairs again; ask(*detector_, good, again))
      note(report_.input_faults, !same(again, right), "other pairs after bad input", good, "");
  }

  const ConformanceConfig& config_;
  Make make_;
  std::unique_ptr<BroadPhase> detector_;
  std::vector<std::unique_ptr<BroadPhase>> by_threads_;
  ConformanceReport report_;
  std::set<std::string> kinds_noted_;
  CandidatePairs out_, other_out_;
  bool served_ = false;
};

void Examinee::check_budgets(const Call& call) {
  if (!serves(call)) return;
  CandidatePairs right;
  if (!ask(*detector_, call, right) || right.size() == 0) return;
  expect_over_budget(call, {.pairs = right.size() - 1}, right);
  expect_over_budget(call, {.bytes = right.size()}, right);
  detector_->set_budget({.pairs = right.size()});
  if (CandidatePairs out; ask(*detector_, call, out))
    note(report_.budget_faults, !same(out, right), "other pairs with a budget", call, "");
  detector_->set_budget({});
}

/// A surface in its own arrays, which the test may corrupt.
struct Copy {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  double thickness;

  explicit Copy(const SurfaceView& s)
      : x_t0(s.x_t0.begin(), s.x_t0.end()),
        x_t1(s.x_t1.begin(), s.x_t1.end()),
        edges(s.edges.begin(), s.edges.end()),
        triangles(s.triangles.begin(), s.triangles.end()),
        thickness(s.thickness) {}
  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, thickness}; }
};

void Examinee::check_bad_input(const Call& good) {
  if (!serves(good)) return;
  CandidatePairs right;
  if (!ask(*detector_, good, right)) return;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto n = static_cast<std::int32_t>(good.a.x_t0.size());
  const auto refuse = [&](const char* what, const std::string& word, auto spoil) {
    Copy copy(good.a);
    spoil(copy);
    Call call = good;
    call.a = copy.view();
    call.name = std::string(what) + " in " + good.name;
    expect_refusal(call, word, good, right);
  };
  const std::int32_t last = n - 1;
  refuse("a NaN", "vertex 1 ", [&](Copy& s) { s.x_t1[1].y() = nan; });
  refuse("an infinity", "vertex " + std::to_string(last),
         [&](Copy& s) { s.x_t0[last].z() = -infinity; });
  refuse("an index too large", "triangle 1 ", [&](Copy& s) { s.triangles[1][2] = n; });
  refuse("a negative index", "edge 2 ", [&](Copy& s) { s.edges[2][0] = -1; });
  refuse("a missing position", "", [&](Copy& s) { s.x_t1.pop_back(); });
  refuse("a negative thickness", "thickness", [&](Copy& s) { s.thickness = -1.0; });
  refuse("a thickness that is no number", "thickness", [&](Copy& s) { s.thickness = nan; });
}

/// All calls for the current step of a scene.
std::vector<Call> calls_of(const ConformanceScene& scene, std::uint64_t seed, int step,
                           bool with_all_threads) {
  const Call both{scene.a(),
                  scene.b(),
                  false,
                  scene.b_is_closed(),
                  scene.b_keeps_shape(),
                  scene.is_beyond_float(),
                  "a and b of " + scene.description(),
                  seed,
                  step,
                  with_all_threads};
  std::vector<Call> calls = {both};
  const auto alone = [&](const SurfaceView& s, bool self, const std::string& name) {
    Call call = both;
    call.a = call.b = s;
    call.self = self;
    call.b_is_closed = call.b_keeps_shape = false;
    call.name = name + scene.description();
    calls.push_back(call);
  };
  alone(scene.a(), true, "a with itself of ");
  if (step % 2 == 1) alone(scene.b(), true, "b with itself of ");
  if (step == 1) alone(scene.a(), false, "a twice, as two surfaces, of ");
  return calls;
}

class Examination {
 public:
  Examination(const BroadPhaseRegistry& registry, const ConformanceConfig& config)
      : config_(config), brute_(make_brute_force()) {
    if (config.scenes_per_detector == 0 || config.scenes_per_thread_check == 0 ||
        config.touching_pairs == 0)
      throw std::invalid_argument(
          "conformance: scenes_per_detector, scenes_per_thread_check and touching_pairs must be at "
          "least 1");
    for (const auto& [name, make] : registry) examinees_.emplace_back(name, make, config_);
    brute_->set_budget({.pairs = std::numeric_limits<std::size_t>::max(),
                        .bytes = std::numeric_limits<std::size_t>::max()});
  }

  void run() {
    for (std::size_t i = 0; i < config_.scenes; ++i) run_scene(i);
    check_borders();
  }

  std::map<std::string, ConformanceReport> take_reports() {
    std::map<std::string, ConformanceReport> reports;
    for (Examinee& e : examinees_) {
      ConformanceReport report = e.take_report();
      reports[report.detector] = std::move(report);
    }
    return reports;
  }

 private:
  void run_scene(std::size_t number) {
    const std::uint64_t seed = config_.first_seed + number;
    ConformanceScene scene(seed);
    // Most detectors do not start a second thread for small scenes.
    const bool threads = scene.is_large() || number % config_.scenes_per_thread_check == 0;
    for (Examinee& e : examinees_) e.begin_scene(number);
    for (int step = 0; step < scene.step_count(); ++step) {
      if (step > 0) scene.advance();
      for (Call& call : calls_of(scene, seed, step, threads)) {
        find_truth(call);
        for (Examinee& e : examinees_) e.answer(call);
      }
    }
  }

  void find_truth(Call& call) {
    call.ask(*brute_, call.boxes);
    const bool needed = std::any_of(examinees_.begin(), examinees_.end(),
                                    [](const Examinee& e) { return e.needs_touching(); });
    if (!config_.touching || (!needed && call.seed % 10 != 0)) return;
    const CandidatePairs some = sample(call.boxes, config_.touching_pairs);
    config_.touching(call.a, call.self ? call.a : call.b, some, call.touching);
    call.touching = as_sets(std::move(call.touching));
  }

  /// Tests budgets and invalid input on the first scene that every detector supports: two closed
  /// bodies, one static.
  void check_borders() {
    for (std::uint64_t seed = 0;; ++seed) {
      const ConformanceScene scene(seed);
      std::vector<Call> calls = calls_of(scene, seed, 0, false);
      if (!scene.b_is_closed() || !scene.b_keeps_shape() || scene.a().triangles.size() < 20)
        continue;
      for (Call& call : calls) call.ask(*brute_, call.boxes);
      if (calls[0].boxes.size() < 20 || calls[1].boxes.size() < 20) continue;
      for (Examinee& e : examinees_)
        for (const Call& call : calls) {
          e.check_budgets(call);
          e.check_bad_input(call);
        }
      return;
    }
  }

  const ConformanceConfig& config_;
  std::unique_ptr<BroadPhase> brute_;
  std::vector<Examinee> examinees_;
};

double part(std::uint64_t of, std::uint64_t all) {
  return all == 0 ? 1.0 : static_cast<double>(of) / static_cast<double>(all);
}

}  // namespace

double ConformanceReport::box_recall() const { return part(boxes_found, boxes); }
double ConformanceReport::touching_recall() const { return part(touching_found, touching); }

std::string ConformanceReport::summary() const {
  std::ostringstream text;
  text << detector << ": " << (passed() ? "passed" : "FAILED") << "; " << scenes << " scenes, "
       << calls << " calls, " << pairs << " pairs; box recall " << box_recall()
       << ", touching recall " << touching_recall() << "; lost " << lost << ", beyond the boxes "
       << beyond << ", duplicates " << duplicates << ", malformed " << malformed << "; unsorted "
       << unsorted << ", thread-dependent " << thread_dependent << ", refused " << refused
       << ", failed " << failed << "; budgets " << budget_faults << ", bad input " << input_faults;
  for (const ConformanceFault& fault : faults)
    text << "\n  seed " << fault.seed << ", step " << fault.step << ": " << fault.what;
  return text.str();
}

std::map<std::string, ConformanceReport> check_conformance(const BroadPhaseRegistry& registry,
                                                           const ConformanceConfig& config) {
  Examination examination(registry, config);
  examination.run();
  return examination.take_reports();
}

ConformanceReport check_conformance(const std::function<std::unique_ptr<BroadPhase>()>& make,
                                    const ConformanceConfig& config) {
  BroadPhaseRegistry registry;
  registry.add("detector", {}, [make](const MethodOptions&) { return make(); });
  return check_conformance(registry, config).at("detector");
}

}  // namespace selvedge
