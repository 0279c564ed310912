// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/lab/fabric_drape.h>

#include <algorithm>
#include <numeric>

namespace selvedge {

double DrapeStatistics::mean() const {
  return std::accumulate(coefficient.begin(), coefficient.end(), 0.0) /
         static_cast<double>(coefficient.size());
}

double DrapeStatistics::spread() const {
  const auto [low, high] = std::minmax_element(coefficient.begin(), coefficient.end());
  return *high - *low;
}

std::optional<MeshLimit> DrapeStatistics::limit() const {
  if (refined.size() < 2) return {};
  MeshLimit limit = mesh_limit(refined);
  limit.value += mean() - refined.front();
  return limit;
}

double DrapeStatistics::value() const {
  const auto known = limit();
  return known ? known->value : mean();
}

DrapeStatistics drape_series(const Material& material, const DrapeSeries& series) {
  require(series.seeds >= 1, "seeds", series.seeds, "at least 1");
  require(series.levels >= 1, "levels", series.levels, "at least 1");
  std::vector<std::vector<DrapeOutcome>> outcomes(series.seeds);  // by seed, then by mesh
  parallel_for(series.seeds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      DrapeTrial trial = series.trial;
      trial.seed = static_cast<std::uint32_t>(s + 1);
      if (s == 0 && trial.mesh == DrapeMesh::arc)
        outcomes[s] = drape_refined(material, trial, series.levels);
      else
        outcomes[s].push_back(drape(material, trial));
    }
  });
  DrapeStatistics statistics;
  statistics.strips = strip_drape_coefficient(bending_length(
      0.5 * (material.bending_stiffness + bending_along_weft(material)), material.density));
  for (const auto& meshes : outcomes) {
    statistics.coefficient.push_back(meshes.front().coefficient);
    statistics.folds.push_back(meshes.front().rim.folds);
    for (const DrapeOutcome& outcome : meshes) statistics.unsettled += outcome.settled ? 0 : 1;
  }
  for (const DrapeOutcome& outcome : outcomes.front()) {
    statistics.refined.push_back(outcome.coefficient);
    statistics.refined_folds.push_back(outcome.rim.folds);
  }
  return statistics;
}

}  // namespace selvedge
