// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/field.h"

#include <array>
#include <charconv>
#include <cmath>

namespace acus {

bool Range::contains(double value) const {
  if (std::isnan(value) || (std::isinf(value) && !infinity_allowed)) return false;
  if (min_open ? value <= min : value < min) return false;
  return max_open ? value < max : value <= max;
}

std::string describe(const Range& range) {
  std::string text;
  const bool bounded_below = std::isfinite(range.min);
  const bool bounded_above = std::isfinite(range.max);
  if (bounded_below && bounded_above) {
    text = std::string("in ") + (range.min_open ? "(" : "[") + format_number(range.min) + ", " +
           format_number(range.max) + (range.max_open ? ")" : "]");
  } else if (bounded_below) {
    text = (range.min_open ? "> " : ">= ") + format_number(range.min);
  } else if (bounded_above) {
    text = (range.max_open ? "< " : "<= ") + format_number(range.max);
  }
  if (range.infinity_allowed) text += text.empty() ? "or .inf, -.inf" : " or .inf";
  return text;
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
