// SPDX-License-Identifier: MIT
//
// The causes that an inquiry names: bodies that squeeze or push, handles that carry or pull.
#include <fmt/format.h>
#include <selvedge/simulation/detail/inquiry.h>

#include <algorithm>
#include <cmath>

namespace selvedge::detail {
namespace {

// Two bodies squeeze the cloth between them if the angle between their pushes is at least 120
// degrees. This is the cosine of that angle.
constexpr double kOpposed = -0.5;

// A place counts as one of the fastest approach if two bodies approach each other there at this
// fraction of the largest speed or faster.
constexpr double kAsFast = 0.99;

/// 0.00231 m as "2.31 mm".
std::string length(double metres) {
  const double size = std::abs(metres);
  if (size != 0.0 && size < 1e-6) return fmt::format("{:.3g} nm", 1e9 * metres);
  if (size < 1e-3) return fmt::format("{:.3g} um", 1e6 * metres);
  if (size < 1.0) return fmt::format("{:.3g} mm", 1e3 * metres);
  return fmt::format("{:.3g} m", metres);
}

std::string duration(double seconds) { return fmt::format("{:.3g} ms", 1e3 * seconds); }

/// What helps against a cause, in the words of the scene file.
std::string remedy(const std::string& kind, bool carries_jams) {
  if (kind == "squeeze")
    return std::string("leave the cloth more room there") +
           (carries_jams ? "" : ", or set contact.still_tangled to \"carry\"");
  if (kind == "push") return "slow this body, or leave the cloth a way out";
  if (kind == "carry" || kind == "pull") return "slow this handle, or lead it another way";
  return "more time.steps_per_frame or a larger contact.rest_gap may help";
}

}  // namespace

void Inquiry::find_culprits(std::vector<Culprit>& culprits) const {
  const std::vector<Front> found = fronts();
  add_squeezes(found, culprits);
  add_pushes(found, culprits);
  add_carriers(culprits);
  add_pulls(culprits);
  std::stable_sort(culprits.begin(), culprits.end(),
                   [](const Culprit& a, const Culprit& b) { return a.motion > b.motion; });
  if (culprits.empty() && !failed_.pairs.empty()) culprits.push_back(meeting(failed_.pairs[0]));
  if (culprits.empty())
    culprits.push_back({"meet", "no pair collided in the last attempt: " + failed_.cause, {}});
}

std::string Inquiry::blame() const {
  std::vector<Culprit> culprits;
  find_culprits(culprits);
  return culprits[0].sentence + "; " + remedy(culprits[0].kind, scene_.contact.carry_tangled);
}

std::map<std::pair<std::size_t, std::size_t>, std::vector<Jaws>> Inquiry::closing_jaws(
    const std::vector<Front>& found) const {
  const double least = threshold();
  std::map<std::pair<std::size_t, std::size_t>, std::vector<Jaws>> jaws;
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t j = i + 1; j < found.size(); ++j) {
      const Front &a = found[i], &b = found[j];
      const double nearing = a.push + b.push;
      if (a.towards_cloth.dot(b.towards_cloth) > kOpposed || nearing <= least) continue;
      const double room = a.towards_cloth.dot(point_of(b.contact, b.body_side, failed_.x_t0) -
                                              point_of(a.contact, a.body_side, failed_.x_t0));
      if (room > 0.0)  // otherwise the bodies stand back to back, without the cloth between them
        jaws[std::minmax(a.body, b.body)].push_back({&a, &b, nearing, room});
    }
  return jaws;
}

void Inquiry::add_squeezes(const std::vector<Front>& found, std::vector<Culprit>& culprits) const {
  for (const auto& [owners, jaws] : closing_jaws(found)) {
    double fastest = 0.0;
    for (const Jaws& j : jaws) fastest = std::max(fastest, j.nearing);
    const Jaws* tightest = nullptr;
    for (const Jaws& j : jaws)
      if (j.nearing >= kAsFast * fastest && (tightest == nullptr || j.room < tightest->room))
        tightest = &j;
    culprits.push_back(squeeze(*tightest->a, *tightest->b, tightest->nearing, tightest->room));
  }
}

Culprit Inquiry::squeeze(const Front& a, const Front& b, double nearing, double room) const {
  const bool one = a.body == b.body;
  const std::string name_a = names_.owner_name(a.body), name_b = names_.owner_name(b.body);
  Culprit culprit;
  culprit.kind = "squeeze";
  culprit.names = one ? std::vector{name_a} : std::vector{name_a, name_b};
  culprit.names.push_back(names_.owner(a.vertex));
  culprit.vertex = a.vertex;
  culprit.motion = nearing;
  culprit.room = room;
  culprit.loads = loads_at(a.vertex);
  culprit.sentence = fmt::format(
      "{} {} {} between them: in this attempt of {} they come {} nearer to each other ({} by {}, "
      "{} "
      "by {}), and only {} is left between them at {}",
      one ? "two parts of " + name_a : name_a + " and " + name_b, "squeeze", names_.owner(a.vertex),
      duration(attempt_.h), length(nearing), one ? "one" : name_a, length(a.push),
      one ? "the other" : name_b, length(b.push), length(room), names_.vertex(a.vertex));
  return culprit;
}

void Inquiry::add_pushes(const std::vector<Front>& found, std::vector<Culprit>& culprits) const {
  const double least = threshold();
  std::map<std::size_t, const Front*> hardest;
  for (const Front& f : found) {
    const Front*& known = hardest[f.body];
    if (f.push > least && (known == nullptr || f.push > known->push)) known = &f;
  }
  for (const auto& [body, front] : hardest) {
    const std::string name = names_.owner_name(body);
    const bool named = std::any_of(culprits.begin(), culprits.end(), [&](const Culprit& c) {
      return std::find(c.names.begin(), c.names.end(), name) != c.names.end();
    });
    if (front == nullptr || named) continue;
    culprits.push_back({"push",
                        fmt::format("{} pushes {}: it moves by {} towards {} in this attempt of {}",
                                    name, names_.owner(front->vertex), length(front->push),
                                    names_.vertex(front->vertex), duration(attempt_.h)),
                        {name, names_.owner(front->vertex)},
                        front->vertex,
                        front->push,
                        0.0,
                        loads_at(front->vertex)});
  }
}

void Inquiry::add_carriers(std::vector<Culprit>& culprits) const {
  std::set<std::string> named;
  for (const ContactPoint& c : failed_.pairs)
    for (int k = 0; k < 4; ++k) {
      const std::int32_t v = c.vertex[k];
      const double distance = moved(v).norm();
      if (!is_held(v) || distance <= threshold() || !named.insert(handle_name(v)).second) continue;
      const std::int32_t other = c.vertex[k < first_count(c) ? 3 : 0];
      culprits.push_back(
          {"carry",
           fmt::format("{} carries {} into {}: it moves it by {} in this attempt of {}",
                       handle_name(v), names_.vertex(v), names_.owner(other), length(distance),
                       duration(attempt_.h)),
           {handle_name(v), names_.owner(v), names_.owner(other)},
           v,
           distance});
    }
}

// Without the forces of the solve, a particle counts that its own handle may pull.
Inquiry::Pulled Inquiry::hardest_pulled() const {
  Pulled hardest;
  for (const ContactPoint& c : failed_.pairs)
    for (int k = 0; k < 4; ++k) {
      if (!is_cloth(c.vertex[k]) || is_held(c.vertex[k])) continue;
      const double side = k < first_count(c) ? -1.0 : 1.0;  // into the other primitive
      const double pull = side * c.normal.dot(neighbours_force(c.vertex[k]));
      const bool first = hardest.vertex < 0 && attempt_.v.empty();
      if (pull > hardest.force || first)
        hardest = {c.vertex[k], c.vertex[k < first_count(c) ? 3 : 0], pull};
    }
  return hardest;
}

void Inquiry::add_pulls(std::vector<Culprit>& culprits) const {
  const Pulled pulled = hardest_pulled();
  if (pulled.vertex < 0) return;
  const auto [held, hops] = nearest_held(pulled.vertex);
  if (held < 0 || hops == 0) return;
  const double distance = moved(held).norm();
  if (distance <= threshold()) return;
  const std::string force =
      pulled.force > 0.0 ? fmt::format(", which its neighbours pull with {:.3g} N", pulled.force)
                         : ", which collides";
  culprits.push_back(
      {"pull",
       fmt::format("{} pulls at {}: it moves its end by {} in this attempt of {}, {} edges from "
                   "{}{} {} {}",
                   handle_name(held), names_.owner(held), length(distance), duration(attempt_.h),
                   hops, names_.vertex(pulled.vertex), force, pulled.force > 0.0 ? "into" : "with",
                   names_.owner(pulled.other)),
       {handle_name(held), names_.owner(held), names_.owner(pulled.other)},
       pulled.vertex,
       distance,
       0.0,
       loads_at(pulled.vertex)});
}

Culprit Inquiry::meeting(const ContactPoint& c) const {
  const double approach =
      -c.normal.dot(relative(c, failed_.x_t1) - relative(c, failed_.x_t0)) / attempt_.h;
  const std::string brought_by = explain_pair(c).brought_by;
  const std::int32_t second = c.vertex[first_count(c)];
  return {"meet",
          fmt::format("{} runs into {}: at {} they near each other at {:.3g} m/s{}",
                      names_.owner(c.vertex[0]), names_.owner(second), names_.pair(c), approach,
                      attempt_.stages.empty() ? ""
                      : brought_by.empty()    ? ", and no stage of the step parted them"
                                              : ", brought there by: " + brought_by),
          {names_.owner(c.vertex[0]), names_.owner(second)},
          c.vertex[0],
          approach * attempt_.h,
          0.0,
          loads_at(c.vertex[0])};
}

Culprit Inquiry::nowhere() const {
  const std::int32_t v = failed_.not_finite;
  std::string stage = "the start of the step";
  for (const RecordedStage& s : attempt_.stages)
    if (!s.x_t1[v].allFinite()) {
      stage = "\"" + s.name + "\"";
      break;
    }
  const Vec3 velocity = v_[v];
  return {"not finite",
          fmt::format("{} loses its position in {}: it starts at {:.3g} m/s with a mass of "
                      "{:.3g} kg; look for a stiffness, a speed or a time step out of all "
                      "proportion",
                      names_.vertex(v), stage, velocity.norm(),
                      attempt_.inv_mass[v] > 0.0 ? 1.0 / attempt_.inv_mass[v] : 0.0),
          {names_.owner(v)},
          v};
}

}  // namespace selvedge::detail
