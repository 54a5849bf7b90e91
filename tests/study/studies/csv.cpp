// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/csv.h"

#include <cassert>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace acus {

namespace {

std::string six_digits(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", number);
  return text;
}

// In quotation marks where the word would break the row otherwise.
std::string quoted(std::string word) {
  if (word.find_first_of(",\"\n") == std::string::npos) return word;
  std::string text = "\"";
  for (const char c : word) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + '"';
}

}  // namespace

Cell::Cell(double number) : text_(std::isnan(number) ? "" : six_digits(number)) {}

Cell::Cell(std::string word) : text_(quoted(std::move(word))) {}

CsvFile::CsvFile(const std::string& path, const std::vector<std::string>& columns)
    : path_(path), columns_(columns.size()), file_(path, std::ios::trunc) {
  row(std::vector<Cell>(columns.begin(), columns.end()));
}

void CsvFile::row(const std::vector<Cell>& cells) {
  assert(cells.size() == columns_);
  const char* separator = "";
  for (const Cell& cell : cells) {
    file_ << separator << cell.text();
    separator = ",";
  }
  file_ << std::endl;
  require_written();
}

void CsvFile::require_written() const {
  if (!file_) throw std::runtime_error(path_ + " cannot be written; does its folder exist?");
}

}  // namespace acus
