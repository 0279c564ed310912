// SPDX-License-Identifier: MIT
#include <selvedge/core/base/fields.h>

#include <cmath>
#include <cstdio>

namespace selvedge {
namespace {

std::string must_be(const char* relation, double limit, double value) {
  char text[96];
  std::snprintf(text, sizeof text, "must be %s %g, is %g", relation, limit, value);
  return text;
}

}  // namespace

std::string range_fault(const ValueRange& range, double value) {
  if (!std::isfinite(value)) return "must be a finite number";
  if (range.above_least && value <= range.least) return must_be("greater than", range.least, value);
  if (value < range.least) return must_be("at least", range.least, value);
  if (value > range.most) return must_be("at most", range.most, value);
  return {};
}

void detail::check_field(double value, const Key& key, const std::string& place) {
  ValueRange range = key.range;
  if (!range.firm) range.most = ValueRange{}.most;
  if (const std::string fault = range_fault(range, value); !fault.empty())
    throw std::invalid_argument(place + " " + fault);
}

}  // namespace selvedge
