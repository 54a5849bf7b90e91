// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/text/text_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "protocol/printable.h"
#include "server/engine/scene/text/field.h"

namespace acus {
namespace {

// Bytes 10xxxxxx continue with a character that began before.
std::size_t width_of(const std::string& utf8) {
  const auto begins_character = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
  return static_cast<std::size_t>(std::count_if(utf8.begin(), utf8.end(), begins_character));
}

}  // namespace

std::string five_digits(double value) {
  if (!std::isfinite(value)) return format_number(value);
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.5g", value);
  return buffer.data();
}

void TextTable::add(std::vector<std::string> cells) {
  for (std::string& cell : cells) cell = protocol::printable(cell);
  rows_.push_back(std::move(cells));
}

std::string TextTable::text() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width_of(row[i]));
  }
  std::string text;
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      text += row[i];
      if (i + 1 < row.size()) text.append(widths[i] - width_of(row[i]) + 2, ' ');
    }
    text += '\n';
  }
  return text;
}

}  // namespace acus
