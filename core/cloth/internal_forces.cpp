// SPDX-License-Identifier: MIT
#include <selvedge/core/base/registry.h>
#include <selvedge/core/cloth/fabric_laws.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace selvedge {

// A law is a source that defines register_NAME(FabricLaws&), and a line here. The order is that in
// which internal forces add up.
#define SELVEDGE_LAWS(LAW) \
  LAW(hooke)               \
  LAW(spring_curves)       \
  LAW(membrane)            \
  LAW(yarns)               \
  LAW(shape_operator)      \
  LAW(bending)             \
  LAW(bridson)             \
  LAW(buckling)            \
  LAW(chord)               \
  LAW(bending_curves)      \
  LAW(twisting)            \
  LAW(beam)                \
  LAW(crossings)           \
  LAW(hysteresis)          \
  LAW(tie)                 \
  LAW(plate)               \
  LAW(volume)              \
  LAW(virtual_springs)     \
  LAW(sewing)              \
  LAW(water)               \
  LAW(gravity)             \
  LAW(air)

#define SELVEDGE_DECLARE_LAW(name) void register_##name(FabricLaws& laws);
SELVEDGE_LAWS(SELVEDGE_DECLARE_LAW)
#undef SELVEDGE_DECLARE_LAW

const FabricLaws& fabric_laws() {
  static const FabricLaws all = [] {
    FabricLaws laws;
#define SELVEDGE_ADD_LAW(name) register_##name(laws);
    SELVEDGE_LAWS(SELVEDGE_ADD_LAW)
#undef SELVEDGE_ADD_LAW
    return laws;
  }();
  return all;
}

ForceLawRegistry force_laws() { return fabric_laws().forces; }

namespace {

template <class Law>
const Law& law_named(const char* key, const std::vector<Law>& laws, const std::string& name) {
  std::vector<std::string> names;
  for (const Law& law : laws) {
    if (law.name == name) return law;
    names.push_back(law.name);
  }
  throw std::invalid_argument(std::string(key) + ": " + unknown_name(name, names, {}));
}

}  // namespace

const StretchLaw& stretch_law_of(const Material& m) {
  return law_named("stretch_law", fabric_laws().stretch, m.stretch_law);
}
const ShearLaw& shear_law_of(const Material& m) {
  return law_named("shear_law", fabric_laws().shear, m.shear_law);
}
const BendingLaw& bending_law_of(const Material& m) {
  return law_named("bending_law", fabric_laws().bending, m.bending_law);
}

double constant_of_law(const Material& m, const std::string& name) {
  for (const LawConstant& constant : fabric_laws().constants)
    if (constant.name == name) return constant(m);
  throw std::logic_error("no law defines the constant " + name);
}

bool reads(const std::vector<std::string>& constants, const std::string& constant) {
  return std::find(constants.begin(), constants.end(), constant) != constants.end();
}

ForceList make_forces_of(const ForceLawRegistry::Entry& law, const ClothMesh& cloth,
                         const ForceLawOptions& options) {
  const auto given = options.find(law.name());
  return given == options.end() ? law(cloth) : law(given->second, cloth);
}

ForceList make_internal_forces(const ClothMesh& cloth, const ForceLawRegistry& laws,
                               const ForceLawOptions& options) {
  for (const auto& [name, values] : options)
    if (const std::string fault = laws.fault(name); !fault.empty())
      throw std::invalid_argument("force_laws: " + fault);
  ForceList forces;
  for (const auto* law : laws.in_order())
    for (auto& force : make_forces_of(*law, cloth, options)) forces.push_back(std::move(force));
  return forces;
}

}  // namespace selvedge
