// SPDX-License-Identifier: GPL-3.0-or-later
// A CSV file with a header, written row by row, so that a study that is stopped keeps what it has found.
#pragma once

#include <concepts>
#include <fstream>
#include <initializer_list>
#include <string>
#include <vector>

namespace acus {

// A number with six digits, a word, yes or no. NaN stands for what does not apply and leaves the cell empty.
class Cell {
 public:
  Cell(double number);
  Cell(bool yes) : text_(yes ? "yes" : "no") {}
  Cell(std::integral auto number) : text_(std::to_string(number)) {}
  Cell(std::string word);
  Cell(const char* word) : Cell(std::string(word)) {}

  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// A column of a table whose rows are made of one Source each.
template <class Source>
struct Column {
  const char* name;
  Cell (*cell)(const Source&);
};

template <class Source, std::size_t n>
std::vector<std::string> names_of(const Column<Source> (&columns)[n]) {
  std::vector<std::string> names;
  for (const Column<Source>& column : columns) names.emplace_back(column.name);
  return names;
}

template <class Source, std::size_t n>
std::vector<Cell> cells_of(const Column<Source> (&columns)[n], const Source& source) {
  std::vector<Cell> cells;
  for (const Column<Source>& column : columns) cells.push_back(column.cell(source));
  return cells;
}

class CsvFile {
 public:
  // Throws std::runtime_error if the file cannot be written.
  CsvFile(const std::string& path, const std::vector<std::string>& columns);

  // As many cells as there are columns. Throws std::runtime_error if they cannot be written.
  void row(const std::vector<Cell>& cells);

 private:
  void require_written() const;

  std::string path_;
  std::size_t columns_;
  std::ofstream file_;
};

}  // namespace acus
