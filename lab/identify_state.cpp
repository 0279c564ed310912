// SPDX-License-Identifier: MIT
//
// The state of a genetic search in a file, from which the search continues.
#include <selvedge/core/base/internal/json_value.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/lab/identify.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace selvedge {
namespace {

using StateJson = nlohmann::ordered_json;

/// The settings that must be equal when a search continues.
StateJson settings_of(const DrapeSearch& search, const GeneticConfig& config) {
  StateJson names = StateJson::array();
  for (const IdentifiedConstant& constant : search.constants) names.push_back(constant.name);
  return {{"constants", names},
          {"cells", search.trial.cells},
          {"target", search.target.coefficient},
          {"synthetic", search.synthetic},
          {"fabric", search.fabric},
          {"islands", config.islands},
          {"population", config.population},
          {"seed", config.seed}};
}

Candidate candidate_of(const JsonValue<StateJson>& j) {
  const char* key = j.has("residual") ? "residual" : "misfit";  // as in older files
  return {j["logs"].numbers(), j[key].number()};
}

/// True if every island has all its candidates, with one coordinate for each constant.
bool is_complete(const GeneticState& state, const DrapeSearch& search,
                 const GeneticConfig& config) {
  return state.generation >= 1 && state.islands.size() == std::size_t(config.islands) &&
         std::all_of(state.islands.begin(), state.islands.end(), [&](const auto& island) {
           return island.size() == std::size_t(config.population) &&
                  std::all_of(island.begin(), island.end(), [&](const Candidate& c) {
                    return c.logs.size() == search.constants.size();
                  });
         });
}

}  // namespace

void write_state(const std::filesystem::path& file, const DrapeSearch& search,
                 const GeneticConfig& config, const GeneticState& state) {
  StateJson islands = StateJson::array();
  for (const auto& island : state.islands) {
    StateJson list = StateJson::array();
    for (const Candidate& c : island) list.push_back({{"logs", c.logs}, {"residual", c.residual}});
    islands.push_back(list);
  }
  AtomicFile out(file);
  out.write(StateJson{{"settings", settings_of(search, config)},
                      {"generation", state.generation},
                      {"islands", islands}}
                .dump(1) +
            "\n");
  out.commit();
}

GeneticState read_state(const std::filesystem::path& file, const DrapeSearch& search,
                        const GeneticConfig& config) {
  const std::string text = read_whole_file(file, {.what = "state of a search"});
  const auto refuse = [&](const std::string& fault) {
    throw std::invalid_argument(file.string() + ": is not the state of a search" + fault +
                                "; name another file, or search without --resume");
  };
  const StateJson json = StateJson::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) refuse("");
  const JsonValue root(json);
  GeneticState state;
  try {
    if (root["settings"].json() != settings_of(search, config))
      throw std::invalid_argument(file.string() + ": belongs to another search; name another file");
    state.generation = root["generation"].whole<int>(1);
    for (const auto& island : root["islands"].list()) {
      auto& candidates = state.islands.emplace_back();
      for (const auto& c : island.list()) candidates.push_back(candidate_of(c));
    }
  } catch (const JsonFault& fault) {
    refuse(std::string(" (") + fault.what() + ")");
  }
  if (!is_complete(state, search, config)) refuse("");
  return state;
}

namespace {

/// A new search replaces the state of an earlier one, and nothing else.
void refuse_other_content(const std::filesystem::path& file) {
  const std::string text = read_if_there(file);
  const StateJson json = StateJson::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!text.empty() && !(json.is_object() && json.contains("islands")))
    throw std::invalid_argument(file.string() +
                                ": holds something else than the state of a search; name another "
                                "file, or remove it");
}

}  // namespace

SearchResult resumable_genetic(const DrapeSearch& search, const GeneticConfig& config,
                               const GeneticFile& keep,
                               const std::function<void(const GeneticState&)>& kept) {
  if (keep.resume && keep.file.empty())
    throw std::invalid_argument("identify: a search resumes from the file that keeps its state");
  if (!keep.resume && !keep.file.empty()) refuse_other_content(keep.file);
  const GeneticState before = keep.resume ? read_state(keep.file, search, config) : GeneticState{};
  SearchResult result;
  result.best = genetic(search, config, before, [&](const GeneticState& state) {
    if (!keep.file.empty()) write_state(keep.file, search, config, state);
    if (kept) kept(state);
  });
  result.evaluations =
      std::max(0, config.generations - before.generation) * config.islands * config.population;
  return result;
}

}  // namespace selvedge
