// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of text in aligned columns.
#pragma once

#include <string>
#include <vector>

namespace acus {

// Of a number, for a person to read; .inf as scenes write it.
std::string five_digits(double value);

class TextTable {
 public:
  // Control characters are shown.
  void add(std::vector<std::string> cells);

  // One line per row, two spaces between columns; widths count characters of UTF-8.
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace acus
