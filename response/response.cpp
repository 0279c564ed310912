// SPDX-License-Identifier: MIT
#include <selvedge/response/contact_force.h>
#include <selvedge/response/response.h>

namespace selvedge {

ResponseRegistry responses() {
  return {{"contact_force", [] { return std::make_unique<ContactForce>(); }}};
}

}  // namespace selvedge
