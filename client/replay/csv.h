// SPDX-License-Identifier: MIT
// Lines of CSV as spreadsheets write them: cells between commas, semicolons or tabs, in quotes where they hold what
// stands between cells, and numbers with a decimal point or a comma.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace acus::client {

struct Cell {
  std::string_view text;   // trimmed, of a cell in quotes what stands between them
  std::size_t column = 1;  // of its first character in the line, from 1
};

// The text behind its byte-order mark.
std::string_view without_mark(std::string_view text);

// Why this cannot be text in UTF-8, with the remedy; empty for what can.
std::string_view not_utf8(std::string_view text);

// ';' or a tab where a header has one, a comma otherwise.
char separator_of(std::string_view header);

// Nothing where a quote is not closed.
std::optional<std::vector<Cell>> split(std::string_view line, char separator);

// The text of a cell in quotes, in which each quote stands twice.
std::string unquoted(std::string_view text);

// Finite, with the decimal sign given ('.' or ','), without groups of digits.
std::optional<double> number_of(std::string_view text, char decimal);

std::string_view trimmed(std::string_view text);

// Of nothing but separators, or a comment.
bool is_blank(std::string_view line);

}  // namespace acus::client
