// SPDX-License-Identifier: MIT
#include <selvedge/narrowphase/ccd_exact.h>
#include <selvedge/narrowphase/narrow_phase.h>

namespace selvedge {

NarrowPhaseRegistry narrow_phases() {
  NarrowPhaseRegistry registry;
  registry["ccd_exact"] = [] { return make_ccd_exact(); };
  return registry;
}

}  // namespace selvedge
