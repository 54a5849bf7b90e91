// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/text/field.h"

#include <array>
#include <charconv>
#include <cmath>

namespace acus {

bool Range::contains(double value) const {
  if (std::isinf(value)) return infinity_allowed && (value > 0 || min < 0);
  return value >= min && value <= max;  // not-a-number is in no range
}

std::string describe(const Range& range) {
  if (!std::isfinite(range.min)) return "";
  const std::string text = "in [" + format_number(range.min) + ", " + format_number(range.max) + "]";
  if (!range.infinity_allowed) return text;
  return text + (range.min < 0 ? ", .inf or -.inf" : " or .inf");
}

std::string format_number(double value) {
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  if (std::isnan(value)) return ".nan";
  std::array<char, 32> buffer{};
  const double magnitude = std::abs(value);
  const bool plain = value == 0 || (magnitude >= 1e-4 && magnitude < 1e6);
  const auto format = plain ? std::chars_format::fixed : std::chars_format::scientific;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format);
  return {buffer.data(), result.ptr};
}

}  // namespace acus
