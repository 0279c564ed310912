// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/detail/result_json.h>
#include <selvedge/run/detail/run_folder.h>
#include <selvedge/run/result_folder.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <system_error>
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

StepControl control_from(const Value& j) {
  StepControl control{j["done"].whole<std::int64_t>(), j["h"].number(), j["halvings"].whole<int>()};
  // Older checkpoints have no span. Two steps are joined at most.
  if (j.has("span")) control.span = j["span"].whole<int>(1, 2);
  return control;
}

Json to_json(const Tangles& tangles) {
  Json list = Json::array();
  for (const Tangle& t : tangles.list)
    list.push_back({{"side", t.side},
                    {"way", t.way},
                    {"best", t.best},
                    {"since", t.since},
                    {"jam", t.jam},
                    {"pinch", t.pinch}});
  return {{"list", list}, {"kept", tangles.kept}};
}

Tangles tangles_from(const Value& j) {
  Tangles tangles;
  for (const Value& t : j["list"].list()) {
    Tangle& tangle = tangles.list.emplace_back();
    for (std::size_t k : {0, 1}) tangle.side[k] = t["side"][k].wholes<std::int32_t>();
    tangle.way = t["way"].whole<int>();
    tangle.best = t["best"].whole<int>();
    tangle.since = t["since"].whole<int>();
    tangle.jam = t.flag_or("jam", false);
    tangle.pinch = t.flag_or("pinch", false);
  }
  tangles.kept = j["kept"].wholes<std::int32_t>();
  return tangles;
}

Json to_json(const std::vector<Pinch>& pinches) {
  Json list = Json::array();
  for (const Pinch& p : pinches)
    list.push_back({{"vertex", p.vertex},
                    {"triangle", p.triangle},
                    {"reversed", p.reversed},
                    {"share", p.share}});
  return list;
}

std::vector<Pinch> pinches_from(const Value& j) {
  std::vector<Pinch> pinches;
  for (const Value& p : j.list()) {
    Pinch& pinch = pinches.emplace_back();
    pinch.vertex = p["vertex"].whole<std::int32_t>();
    for (std::size_t k : {0, 1}) {
      pinch.triangle[k] = p["triangle"][k].whole<std::int32_t>();
      pinch.reversed[k] = p["reversed"][k].flag();
    }
    pinch.share = p["share"].number();
  }
  return pinches;
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

std::vector<SplitEvent> splits_from(const Value& j) {
  std::vector<SplitEvent> splits;
  for (const Value& e : j.list()) {
    SplitEvent& event = splits.emplace_back();
    event.piece = e["piece"].whole<std::int32_t>();
    event.time = e["time"].number();
    event.join = e.flag_or("join", false);
    for (const Value& c : e["cells"].list())
      event.cells.push_back(
          {c[0].whole<std::int32_t>(), c[1].whole<std::int32_t>(), c[2].whole<std::int32_t>()});
  }
  return splits;
}

Json to_json(const std::vector<MergeEvent>& merges) {
  Json list = Json::array();
  for (const MergeEvent& event : merges)
    list.push_back({{"time", event.time}, {"pairs", event.pairs}});
  return list;
}

std::vector<MergeEvent> merges_from(const Value& j) {
  std::vector<MergeEvent> merges;
  for (const Value& e : j.list()) {
    MergeEvent& event = merges.emplace_back();
    event.time = e["time"].number();
    for (const Value& pair : e["pairs"].list())
      event.pairs.push_back({pair[0].whole<std::int32_t>(), pair[1].whole<std::int32_t>()});
  }
  return merges;
}

constexpr std::size_t kDigits = 16;

void append_memory(std::string& text, std::span<const double> memory) {
  static const char* digits = "0123456789abcdef";
  const std::size_t begin = text.size();
  text.resize(begin + kDigits * memory.size());
  char* to = text.data() + begin;
  for (const double number : memory) {
    const auto bits = std::bit_cast<std::uint64_t>(number);
    for (std::size_t k = kDigits; k-- > 0;) *to++ = digits[(bits >> (4 * k)) & 15];
  }
}

}  // namespace

std::string memory_text(std::span<const double> memory) {
  std::string text;
  append_memory(text, memory);
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

namespace {

void write_fields_without_memory(const SimulationState& state, Json& json) {
  // JSON numbers are written with as many digits as are needed to read the same double.
  json["time"] = state.time;
  json["step"] = state.step;
  json["control"] = to_json(state.control);
  json["acceleration"] = state.acceleration;
  json["still"] = state.still;
  json["given_strain"] = state.given_strain;
  json["tangles"] = to_json(state.tangles);
  if (!state.pinches.empty()) json["pinches"] = to_json(state.pinches);
  json["splits"] = to_json(state.splits);
  json["merges"] = to_json(state.merges);
  json["refined"] = state.refined;
}

// Adds the memory to the text of an object. Its digits need no escapes, and the search for
// characters that do takes longer than all else that a checkpoint writes. Large cloth has megabytes
// of it, so it is written where it belongs.
std::string with_memory(std::string object, const SimulationState& state) {
  const std::string_view end = "\n}\n";
  const std::array<std::pair<std::string_view, std::span<const double>>, 2> parts = {
      {{",\n  \"memory\": \"", state.memory},
       {",\n  \"contact_memory\": \"", state.contact_memory}}};
  object.resize(object.rfind('\n'));  // before its closing brace
  std::size_t size = object.size() + end.size();
  for (const auto& [name, memory] : parts) size += name.size() + kDigits * memory.size() + 1;
  object.reserve(size);
  for (const auto& [name, memory] : parts) {
    object += name;
    append_memory(object, memory);
    object += '"';
  }
  return object.append(end);
}

std::vector<double> memory_at(const Value& value) {
  try {
    return memory_from(value.text());
  } catch (const JsonFault&) {
    throw;
  } catch (const std::invalid_argument&) {
    value.refuse("16 hexadecimal digits for each number");
  }
}

}  // namespace

void write_state_fields(const SimulationState& state, Json& json) {
  write_fields_without_memory(state, json);
  json["memory"] = memory_text(state.memory);
  json["contact_memory"] = memory_text(state.contact_memory);
}

void read_state_fields(const Value& json, SimulationState& state) {
  state.time = json["time"].number();
  state.step = json["step"].whole<std::int64_t>();
  if (json.has("control")) state.control = control_from(json["control"]);
  state.acceleration = json.number_or("acceleration", state.acceleration);
  state.still = json.number_or("still", state.still);
  state.given_strain = json.number_or("given_strain", state.given_strain);
  if (json.has("tangles")) state.tangles = tangles_from(json["tangles"]);
  if (json.has("pinches")) state.pinches = pinches_from(json["pinches"]);
  if (json.has("memory")) state.memory = memory_at(json["memory"]);
  // Older checkpoints have none.
  if (json.has("contact_memory")) state.contact_memory = memory_at(json["contact_memory"]);
  if (json.has("splits")) state.splits = splits_from(json["splits"]);
  if (json.has("merges")) state.merges = merges_from(json["merges"]);
  state.refined = json.flag_or("refined", false);
}

void write_checkpoint(const fs::path& out, int frame, const StateCopy& copy,
                      const RunResult& result) {
  write_ply(out / "checkpoint.ply", copy.state.x, copy.triangles, state_values(copy.state));
  Json checkpoint = {
      {"frame", frame}, {"state_hash", result.state_hash}, {"result", checkpoint_json(result)}};
  write_fields_without_memory(copy.state, checkpoint);
  write_text(out / "checkpoint.json", with_memory(checkpoint.dump(2), copy.state));
}

namespace {

Checkpoint checkpoint_from(const Value& json, const fs::path& out) {
  Checkpoint checkpoint;
  constexpr int kMostFrames = 99'999;  // as in the schema
  checkpoint.frame = json["frame"].whole<int>(0, kMostFrames);
  const std::string hash = json["state_hash"].text();
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
  checkpoint.result = result_from_checkpoint(json["result"]);
  return checkpoint;
}

}  // namespace

Checkpoint read_checkpoint(const fs::path& out) {
  const fs::path file = out / "checkpoint.json";
  const auto json = read_json(file);
  std::error_code ignored;
  if (!json)
    throw std::invalid_argument(fmt::format("{}: {}; run without --resume", file.string(),
                                            fs::exists(file, ignored)
                                                ? "is damaged: it is no JSON object"
                                                : "there is no checkpoint to resume from"));
  try {
    return checkpoint_from(Value(*json), out);
  } catch (const JsonFault& fault) {
    throw std::invalid_argument(
        fmt::format("{}: is damaged: {}; run without --resume", file.string(), fault.what()));
  }
}

}  // namespace selvedge::detail
