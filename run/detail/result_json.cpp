// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/result_json.h>
#include <selvedge/run/result_folder.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <type_traits>

namespace selvedge {
namespace detail {
namespace {

using Json = nlohmann::json;
using Value = JsonValue<Json>;

bool is_kept(FieldRule rule) { return rule.merge != Merge::last; }

/// Turns values into JSON: all fields, or only those of a checkpoint.
template <class J>
class Writer {
 public:
  explicit Writer(bool kept_only) : kept_only_(kept_only) {}

  template <class T>
  requires std::is_integral_v<T> J json(T value)
  const { return value; }

  J json(const std::string& text) const { return text; }

  /// JSON has no such numbers, and null would hide that something went wrong.
  J json(double value) const {
    if (std::isfinite(value)) return value;
    if (std::isnan(value)) return "nan";
    return value > 0.0 ? "inf" : "-inf";
  }

  J json(const FlagCounts& flags) const {
    if (kept_only_) return flags.worst;
    J object = J::object();
    for (int bit = 0; bit < kVertexFlags; ++bit)
      object[flag_name(bit)] = {{"end", flags.end[bit]}, {"worst", flags.worst[bit]}};
    return object;
  }

  template <class T>
  J json(const std::map<std::string, T>& values) const {
    J object = J::object();
    for (const auto& [name, value] : values) object[name] = json(value);
    return object;
  }

  template <HasFields T>
  J json(const T& record) const {
    J object = J::object();
    Fields<T>::visit([&](const char* name, auto member, FieldRule rule) {
      if (!kept_only_ || is_kept(rule)) object[name] = json(record.*member);
    });
    return object;
  }

 private:
  bool kept_only_;
};

/// Reads values from the JSON of a Writer with the same `kept_only`.
class Reader {
 public:
  explicit Reader(bool kept_only) : kept_only_(kept_only) {}

  void read(const Value& j, bool& value) const { value = j.flag(); }
  void read(const Value& j, std::string& value) const { value = j.text(); }
  template <std::integral T>
  void read(const Value& j, T& value) const {
    value = j.whole<T>();
  }

  void read(const Value& j, double& value) const {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    if (j.json() == "nan")
      value = std::numeric_limits<double>::quiet_NaN();
    else if (j.json() == "inf" || j.json() == "-inf")
      value = j.json() == "inf" ? kInfinity : -kInfinity;
    else
      value = j.number();
  }

  void read(const Value& j, FlagCounts& flags) const {
    if (kept_only_) {
      for (int bit = 0; bit < kVertexFlags; ++bit)
        read(j[static_cast<std::size_t>(bit)], flags.worst[bit]);
      return;
    }
    for (int bit = 0; bit < kVertexFlags; ++bit) {
      const Value counts = j[flag_name(bit)];
      read(counts["end"], flags.end[bit]);
      read(counts["worst"], flags.worst[bit]);
    }
  }

  template <class T>
  void read(const Value& j, std::map<std::string, T>& values) const {
    values.clear();
    for (const auto& [name, value] : j.members()) read(value, values[name]);
  }

  template <HasFields T>
  void read(const Value& j, T& record) const {
    Fields<T>::visit([&](const char* name, auto member, FieldRule rule) {
      if (kept_only_ && !is_kept(rule)) return;
      // Older checkpoints have no plan, older results no rest.
      if (std::string_view(name) == (kept_only_ ? "plan" : "rest") && !j.has(name)) return;
      read(j[name], record.*member);
    });
  }

 private:
  bool kept_only_;
};

/// Gives counters of older files their present names.
void rename_old_counters(std::map<std::string, double>& counters) {
  if (auto old = counters.extract("max_gap_lack_m")) {
    old.key() = "max_gap_violation_m";
    counters.insert(std::move(old));
  }
}

RunResult read(const Value& j, bool kept_only) {
  RunResult r;
  Reader(kept_only).read(j, r);
  rename_old_counters(r.counters);
  return r;
}

}  // namespace

nlohmann::ordered_json result_json(const RunResult& r) {
  return Writer<nlohmann::ordered_json>(false).json(r);
}
Json checkpoint_json(const RunResult& r) { return Writer<Json>(true).json(r); }

RunResult result_from(const Value& j) { return read(j, false); }
RunResult result_from_checkpoint(const Value& j) { return read(j, true); }

}  // namespace detail

std::string result_text(const RunResult& result) {
  return detail::result_json(result).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) +
         "\n";
}

RunResult result_from_text(const std::string& text) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    return detail::result_from(JsonValue(json));
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument("not the result of a run: " + json_message(error.what()));
  } catch (const JsonFault& fault) {
    throw std::invalid_argument(std::string("not the result of a run: ") + fault.what());
  }
}

void write_result(const std::filesystem::path& file, const RunResult& result) {
  AtomicFile out(file);
  out.write(result_text(result));
  out.commit();
}

}  // namespace selvedge
