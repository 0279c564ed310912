// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/check.h>

#include <sstream>
#include <stdexcept>

namespace selvedge {

void require(bool good, const std::string& name, double value, const char* rule) {
  if (good) return;
  std::ostringstream text;
  text << name << " must be " << rule << ", not " << value;
  throw std::invalid_argument(text.str());
}

}  // namespace selvedge
