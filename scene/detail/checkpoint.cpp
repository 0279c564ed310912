// SPDX-License-Identifier: MIT
#include <selvedge/scene/detail/checkpoint.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <map>
#include <stdexcept>

namespace selvedge::detail {

namespace fs = std::filesystem;

std::vector<NamedValues> velocity_values(std::span<const Vec3> v) {
  std::vector<NamedValues> values = {{"vx", {}}, {"vy", {}}, {"vz", {}}};
  for (int axis = 0; axis < 3; ++axis) {
    values[axis].values.reserve(v.size());
    for (const Vec3& velocity : v) values[axis].values.push_back(velocity[axis]);
  }
  return values;
}

std::vector<NamedValues> state_values(const SimulationState& state) {
  std::vector<NamedValues> values = velocity_values(state.v);
  if (!state.water.empty()) values.push_back({"water", state.water});
  return values;
}

std::vector<NamedValues> frame_values(const Simulation& simulation) {
  std::vector<NamedValues> values = state_values(simulation.state());
  const std::vector<std::uint8_t> flags = simulation.flags();
  values.push_back({"flag", {flags.begin(), flags.end()}, true});
  return values;
}

std::vector<Vec3> velocities(const std::vector<NamedValues>& values, const fs::path& file) {
  std::vector<Vec3> v;
  const std::string names[3] = {"vx", "vy", "vz"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto found = std::find_if(values.begin(), values.end(),
                                    [&](const NamedValues& n) { return n.name == names[axis]; });
    if (found == values.end())
      throw std::invalid_argument(file.string() + ": has no velocities; it is no frame of a run");
    v.resize(found->values.size());
    for (std::size_t i = 0; i < v.size(); ++i) v[i][axis] = found->values[i];
  }
  return v;
}

std::optional<SimulationState> read_state(const fs::path& file, const std::string& hash) {
  try {
    std::vector<NamedValues> values;
    SimulationState state;
    state.x = read_ply(file, values).vertices;
    state.v = velocities(values, file);
    for (NamedValues& named : values)
      if (named.name == "water") state.water = std::move(named.values);
    if (state.v.size() == state.x.size() && state_hash(state) == hash) return state;
  } catch (const std::invalid_argument&) {  // damaged: the caller has another file to try
  }
  return std::nullopt;
}

Json to_json(const RunResult& r) {
  const TangleReport& t = r.tangle;
  return {{"clean_elsewhere", r.clean_elsewhere},
          {"tangle",
           {{"start_pairs", t.start_pairs},
            {"elsewhere", t.elsewhere},
            {"until_s", t.until_s},
            {"max_speed", t.max_speed}}},
          {"flags", r.flags.worst},
          {"halvings", r.halvings},
          {"retried_steps", r.retried_steps},
          {"wall_s", r.wall_s},
          {"phase_s", r.phase_s},
          {"worst_self_intersections", r.worst_self_intersections},
          {"worst_body_intersections", r.worst_body_intersections},
          {"max_penetration_m", r.max_penetration_m},
          {"max_stretch", r.max_stretch},
          {"strain_residual", r.strain_residual},
          {"peak_bytes", r.peak_bytes},
          {"counters", r.counters},
          {"ledger", r.ledger}};
}

RunResult result_from(const Json& j) {
  RunResult r;
  r.clean_elsewhere = j.at("clean_elsewhere").get<bool>();
  const Json& t = j.at("tangle");
  r.tangle.start_pairs = t.at("start_pairs").get<int>();
  r.tangle.elsewhere = t.at("elsewhere").get<int>();
  r.tangle.until_s = t.at("until_s").get<double>();
  r.tangle.max_speed = t.at("max_speed").get<double>();
  r.flags.worst = j.at("flags").get<decltype(r.flags.worst)>();
  r.halvings = j.at("halvings").get<int>();
  r.retried_steps = j.at("retried_steps").get<int>();
  r.wall_s = j.at("wall_s").get<double>();
  r.phase_s = j.at("phase_s").get<std::map<std::string, double>>();
  r.worst_self_intersections = j.at("worst_self_intersections").get<int>();
  r.worst_body_intersections = j.at("worst_body_intersections").get<int>();
  r.max_penetration_m = j.at("max_penetration_m").get<double>();
  r.max_stretch = j.at("max_stretch").get<double>();
  r.strain_residual = j.at("strain_residual").get<double>();
  r.peak_bytes = j.at("peak_bytes").get<std::size_t>();
  r.counters = j.at("counters").get<std::map<std::string, double>>();
  r.ledger = j.at("ledger").get<decltype(r.ledger)>();
  return r;
}

namespace {

bool is_maximum(const std::string& counter) {
  return counter.starts_with("max_") || counter.starts_with("worst_");
}

void carry_on(const std::map<std::string, double>& before,
              std::map<std::string, double>& counters) {
  for (const auto& [name, value] : before)
    counters[name] = is_maximum(name) ? std::max(counters[name], value) : counters[name] + value;
}

}  // namespace

void carry_on(const TangleReport& before, TangleReport& r) {
  r.start_pairs = std::max(r.start_pairs, before.start_pairs);
  r.elsewhere = std::max(r.elsewhere, before.elsewhere);
  if (r.until_s == 0.0) r.until_s = before.until_s;
  r.max_speed = std::max(r.max_speed, before.max_speed);
}

void carry_on(const RunResult& before, RunResult& r) {
  carry_on(before.tangle, r.tangle);
  r.clean_elsewhere = r.clean_elsewhere && before.clean_elsewhere;
  r.clean = r.clean && r.clean_elsewhere;
  for (std::size_t bit = 0; bit < kVertexFlags; ++bit)
    r.flags.worst[bit] = std::max(r.flags.worst[bit], before.flags.worst[bit]);
  r.halvings += before.halvings;
  r.retried_steps += before.retried_steps;
  r.wall_s += before.wall_s;
  for (const auto& [phase, seconds] : before.phase_s) r.phase_s[phase] += seconds;
  r.worst_self_intersections =
      std::max(r.worst_self_intersections, before.worst_self_intersections);
  r.worst_body_intersections =
      std::max(r.worst_body_intersections, before.worst_body_intersections);
  r.max_penetration_m = std::max(r.max_penetration_m, before.max_penetration_m);
  r.max_stretch = std::max(r.max_stretch, before.max_stretch);
  r.strain_residual = std::max(r.strain_residual, before.strain_residual);
  r.peak_bytes = std::max(r.peak_bytes, before.peak_bytes);
  carry_on(before.counters, r.counters);
  for (const auto& [part, p] : before.plan) {
    r.plan[part].asked += p.asked;
    r.plan[part].left_out += p.left_out;
    r.plan[part].saved_s += p.saved_s;
  }
  for (const auto& [stage, figures] : before.ledger) carry_on(figures, r.ledger[stage]);
}

Json to_json(const StepControl& control) {
  return {{"done", control.done}, {"h", control.h}, {"halvings", control.halvings}};
}

StepControl control_from(const Json& j) {
  return {j.at("done").get<std::int64_t>(), j.at("h").get<double>(), j.at("halvings").get<int>()};
}

Json to_json(const Tangles& tangles) {
  Json list = Json::array();
  for (const Tangle& t : tangles.list)
    list.push_back({{"side", t.side}, {"way", t.way}, {"best", t.best}, {"since", t.since}});
  return {{"list", list}, {"kept", tangles.kept}};
}

Tangles tangles_from(const Json& j) {
  Tangles tangles;
  for (const Json& t : j.at("list")) {
    Tangle& tangle = tangles.list.emplace_back();
    for (std::size_t k : {0, 1}) t.at("side").at(k).get_to(tangle.side[k]);
    tangle.way = t.at("way").get<int>();
    tangle.best = t.at("best").get<int>();
    tangle.since = t.at("since").get<int>();
  }
  j.at("kept").get_to(tangles.kept);
  return tangles;
}

namespace {

constexpr std::size_t kDigits = 16;

}  // namespace

std::string memory_text(std::span<const double> memory) {
  static const char* digits = "0123456789abcdef";
  std::string text;
  text.reserve(kDigits * memory.size());
  for (const double number : memory) {
    const auto bits = std::bit_cast<std::uint64_t>(number);
    for (std::size_t k = kDigits; k-- > 0;) text += digits[(bits >> (4 * k)) & 15];
  }
  return text;
}

std::vector<double> memory_from(const std::string& text) {
  const auto fail = [] {
    throw std::invalid_argument("the memory of a checkpoint is damaged; run without --resume");
  };
  if (text.size() % kDigits != 0) fail();
  std::vector<double> memory(text.size() / kDigits);
  for (std::size_t i = 0; i < memory.size(); ++i) {
    std::uint64_t bits = 0;
    const char* begin = text.data() + kDigits * i;
    const auto read = std::from_chars(begin, begin + kDigits, bits, 16);
    if (read.ec != std::errc{} || read.ptr != begin + kDigits) fail();
    memory[i] = std::bit_cast<double>(bits);
  }
  return memory;
}

Json to_json(const std::vector<SplitEvent>& splits) {
  Json list = Json::array();
  for (const SplitEvent& event : splits) {
    Json cells = Json::array();
    for (const GridCell& c : event.cells) cells.push_back({c.level, c.i, c.j});
    list.push_back({{"piece", event.piece}, {"time", event.time}, {"cells", cells}});
  }
  return list;
}

std::vector<SplitEvent> splits_from(const Json& j) {
  std::vector<SplitEvent> splits;
  for (const Json& e : j) {
    SplitEvent& event = splits.emplace_back();
    event.piece = e.at("piece").get<std::int32_t>();
    event.time = e.at("time").get<double>();
    for (const Json& c : e.at("cells"))
      event.cells.push_back(
          {c.at(0).get<std::int32_t>(), c.at(1).get<std::int32_t>(), c.at(2).get<std::int32_t>()});
  }
  return splits;
}

Json what_decides(Json scene) {
  if (scene.contains("time")) scene["time"].erase("frames");
  for (const char* key : {"output", "description", "$schema"}) scene.erase(key);
  return scene;
}

}  // namespace selvedge::detail
