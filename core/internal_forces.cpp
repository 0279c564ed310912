// SPDX-License-Identifier: MIT
#include <selvedge/core/force.h>

namespace selvedge {

namespace detail {
// Each law stands in its own .cpp. To add one, declare it here and put it into the list below.
ForceLaw hooke_law();
ForceLaw tension_only_law();
ForceLaw biphasic_law();
ForceLaw kawabata_law();
ForceLaw shape_operator_law();
ForceLaw bending_law();
ForceLaw bridson_law();
ForceLaw buckling_law();
ForceLaw twisting_law();
ForceLaw hysteresis_law();
ForceLaw tie_law();
ForceLaw plate_law();
ForceLaw volume_law();
ForceLaw virtual_springs_law();
ForceLaw sewing_law();
ForceLaw water_law();
ForceLaw gravity_law();
ForceLaw air_law();
}  // namespace detail

/// In the order in which internal forces add up.
std::vector<ForceLaw> force_laws() {
  using namespace detail;
  return {hooke_law(),
          tension_only_law(),
          biphasic_law(),
          kawabata_law(),
          shape_operator_law(),
          bending_law(),
          bridson_law(),
          buckling_law(),
          twisting_law(),
          hysteresis_law(),
          tie_law(),
          plate_law(),
          volume_law(),
          virtual_springs_law(),
          sewing_law(),
          water_law(),
          gravity_law(),
          air_law()};
}

ForceList make_internal_forces(const ClothMesh& cloth) {
  ForceList forces;
  for (const ForceLaw& law : force_laws())
    if (law.add != nullptr) law.add(cloth, forces);
  return forces;
}

}  // namespace selvedge
