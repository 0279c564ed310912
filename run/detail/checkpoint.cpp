// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/detail/result_json.h>
#include <selvedge/run/detail/run_folder.h>
#include <selvedge/run/detail/whole_number.h>
#include <selvedge/run/result_folder.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <stdexcept>
#include <utility>

namespace selvedge::detail {

namespace fs = std::filesystem;

namespace {

std::vector<NamedValues> velocity_values(std::span<const Vec3> v) {
  std::vector<NamedValues> values = {{"vx", {}}, {"vy", {}}, {"vz", {}}};
  for (int axis = 0; axis < 3; ++axis) {
    values[axis].values.reserve(v.size());
    for (const Vec3& velocity : v) values[axis].values.push_back(velocity[axis]);
  }
  return values;
}

}  // namespace

std::vector<NamedValues> state_values(const SimulationState& state) {
  std::vector<NamedValues> values = velocity_values(state.v);
  if (!state.water.empty()) values.push_back({"water", state.water});
  return values;
}

namespace {

/// The side of a tangle that each vertex is on; empty without tangles.
std::vector<double> tangle_sides(const StateCopy& copy) {
  constexpr std::size_t tangles_of_a_byte = 127;
  std::vector<double> sides;
  for (std::size_t i = 0; i < copy.state.tangles.list.size(); ++i)
    for (std::size_t side = 0; side < 2; ++side)
      for (const std::int32_t t : copy.state.tangles.list[i].side[side]) {
        if (static_cast<std::size_t>(t) >= copy.triangles.size()) continue;  // of a body
        sides.resize(copy.state.x.size(), 0.0);
        for (const std::int32_t v : copy.triangles[static_cast<std::size_t>(t)])
          sides[static_cast<std::size_t>(v)] =
              static_cast<double>(1 + 2 * (i % tangles_of_a_byte) + side);
      }
  return sides;
}

}  // namespace

std::vector<NamedValues> frame_values(const StateCopy& copy) {
  std::vector<NamedValues> values = state_values(copy.state);
  values.push_back({"flag", {copy.flags.begin(), copy.flags.end()}, true});
  if (auto sides = tangle_sides(copy); !sides.empty())
    values.push_back({"side", std::move(sides), true});
  if (!copy.pressure.empty()) values.push_back({"pressure", copy.pressure});
  return values;
}

std::vector<Vec3> velocities(const std::vector<NamedValues>& values, const fs::path& file) {
  std::vector<Vec3> v;
  const std::string names[3] = {"vx", "vy", "vz"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto found = std::find_if(values.begin(), values.end(),
                                    [&](const NamedValues& n) { return n.name == names[axis]; });
    if (found == values.end())
      throw std::invalid_argument(file.string() +
                                  ": has no velocities; it is not a frame of a run");
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
  } catch (const std::invalid_argument&) {  // damaged: the caller tries another file
  }
  return std::nullopt;
}

namespace {

Json to_json(const StepControl& control) {
  return {{"done", control.done},
          {"h", control.h},
          {"halvings", control.halvings},
          {"span", control.span}};
}

StepControl control_from(const Json& j) {
  StepControl control{whole<std::int64_t>(j.at("done")), j.at("h").get<double>(),
                      whole<int>(j.at("halvings"))};
  // Older checkpoints have no span. Two steps are joined at most.
  if (j.contains("span")) control.span = whole<int>(j["span"]);
  if (control.span != 1 && control.span != 2) throw NotWhole(j["span"]);
  return control;
}

Json to_json(const Tangles& tangles) {
  Json list = Json::array();
  for (const Tangle& t : tangles.list)
    list.push_back(
        {{"side", t.side}, {"way", t.way}, {"best", t.best}, {"since", t.since}, {"jam", t.jam}});
  return {{"list", list}, {"kept", tangles.kept}};
}

Tangles tangles_from(const Json& j) {
  Tangles tangles;
  for (const Json& t : j.at("list")) {
    Tangle& tangle = tangles.list.emplace_back();
    for (std::size_t k : {0, 1}) tangle.side[k] = whole_list<std::int32_t>(t.at("side").at(k));
    tangle.way = whole<int>(t.at("way"));
    tangle.best = whole<int>(t.at("best"));
    tangle.since = whole<int>(t.at("since"));
    tangle.jam = t.value("jam", false);
  }
  tangles.kept = whole_list<std::int32_t>(j.at("kept"));
  return tangles;
}

Json to_json(const std::vector<SplitEvent>& splits) {
  Json list = Json::array();
  for (const SplitEvent& event : splits) {
    Json cells = Json::array();
    for (const GridCell& c : event.cells) cells.push_back({c.level, c.i, c.j});
    list.push_back({{"piece", event.piece}, {"time", event.time}, {"cells", cells}});
    if (event.join) list.back()["join"] = true;
  }
  return list;
}

std::vector<SplitEvent> splits_from(const Json& j) {
  std::vector<SplitEvent> splits;
  for (const Json& e : j) {
    SplitEvent& event = splits.emplace_back();
    event.piece = whole<std::int32_t>(e.at("piece"));
    event.time = e.at("time").get<double>();
    event.join = e.value("join", false);
    for (const Json& c : e.at("cells"))
      event.cells.push_back({whole<std::int32_t>(c.at(0)), whole<std::int32_t>(c.at(1)),
                             whole<std::int32_t>(c.at(2))});
  }
  return splits;
}

Json to_json(const std::vector<MergeEvent>& merges) {
  Json list = Json::array();
  for (const MergeEvent& event : merges)
    list.push_back({{"time", event.time}, {"pairs", event.pairs}});
  return list;
}

std::vector<MergeEvent> merges_from(const Json& j) {
  std::vector<MergeEvent> merges;
  for (const Json& e : j) {
    MergeEvent& event = merges.emplace_back();
    event.time = e.at("time").get<double>();
    for (const Json& pair : e.at("pairs"))
      event.pairs.push_back({whole<std::int32_t>(pair.at(0)), whole<std::int32_t>(pair.at(1))});
  }
  return merges;
}

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

void write_state_fields(const SimulationState& state, Json& json) {
  // JSON numbers are written with as many digits as are needed to read the same double.
  json["time"] = state.time;
  json["step"] = state.step;
  json["control"] = to_json(state.control);
  json["acceleration"] = state.acceleration;
  json["still"] = state.still;
  json["tangles"] = to_json(state.tangles);
  json["memory"] = memory_text(state.memory);
  json["splits"] = to_json(state.splits);
  json["merges"] = to_json(state.merges);
}

void read_state_fields(const Json& json, SimulationState& state) {
  state.time = json.at("time").get<double>();
  state.step = whole<std::int64_t>(json.at("step"));
  if (json.contains("control")) state.control = control_from(json["control"]);
  if (json.contains("acceleration")) state.acceleration = json["acceleration"].get<double>();
  if (json.contains("still")) state.still = json["still"].get<double>();
  if (json.contains("tangles")) state.tangles = tangles_from(json["tangles"]);
  if (json.contains("memory")) state.memory = memory_from(json["memory"]);
  if (json.contains("splits")) state.splits = splits_from(json["splits"]);
  if (json.contains("merges")) state.merges = merges_from(json["merges"]);
}

void write_checkpoint(const fs::path& out, int frame, const StateCopy& copy,
                      const RunResult& result, bool refined) {
  write_ply(out / "checkpoint.ply", copy.state.x, copy.triangles, state_values(copy.state));
  Json checkpoint = {{"frame", frame},
                     {"refined", refined},
                     {"state_hash", result.state_hash},
                     {"result", checkpoint_json(result)}};
  write_state_fields(copy.state, checkpoint);
  write_text(out / "checkpoint.json", checkpoint.dump(2) + "\n");
}

namespace {

Checkpoint checkpoint_from(const Json& json, const fs::path& out) {
  Checkpoint checkpoint;
  checkpoint.frame = whole<int>(json.at("frame"));
  checkpoint.refined = json.value("refined", false);  // older checkpoints do not say
  const auto hash = json.at("state_hash").get<std::string>();
  // checkpoint.ply is written just before checkpoint.json. If a run was killed between the two, its
  // frame or its failure bundle still holds the state that belongs to checkpoint.json.
  const fs::path frame =
      numbered(out / "frames", "cloth", checkpoint.frame, kFrameFileDigits, ".ply");
  std::optional<SimulationState> state;
  for (const fs::path& file : {out / "checkpoint.ply", frame, out / "failure" / "state.ply"})
    if (!state) state = read_state(file, hash);
  if (!state)
    throw std::invalid_argument(fmt::format(
        "{}: neither it nor frame {} holds the state of checkpoint.json; run without --resume",
        (out / "checkpoint.ply").string(), checkpoint.frame));
  checkpoint.state = std::move(*state);
  read_state_fields(json, checkpoint.state);
  checkpoint.result = result_from_checkpoint(json.at("result"));
  return checkpoint;
}

}  // namespace

Checkpoint read_checkpoint(const fs::path& out) {
  const fs::path file = out / "checkpoint.json";
  const auto json = read_json(file);
  if (!json)
    throw std::invalid_argument(fmt::format(
        "{}: there is no checkpoint to resume from; run without --resume", file.string()));
  try {
    return checkpoint_from(*json, out);
  } catch (const Json::exception& error) {
    throw std::invalid_argument(
        fmt::format("{}: is damaged ({}); run without --resume", file.string(), error.what()));
  }
}

}  // namespace selvedge::detail
