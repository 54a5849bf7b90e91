// SPDX-License-Identifier: MIT
#include "client/replay/csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace acus::client {
namespace {

constexpr std::string_view kMark = "\xef\xbb\xbf";
constexpr std::size_t kLooked = 200;  // bytes, for zeros, which every second byte of text in UTF-16 is

// A cell in quotes that begins at `begin`; `end` is set to what follows the last quote.
std::optional<Cell> quoted_cell(std::string_view line, std::size_t begin, std::size_t& end) {
  for (std::size_t i = begin + 1; i < line.size(); ++i) {
    if (line[i] != '"') continue;
    if (i + 1 < line.size() && line[i + 1] == '"') {
      ++i;
      continue;
    }
    end = i + 1;
    return Cell{line.substr(begin + 1, i - begin - 1), begin + 2};
  }
  return std::nullopt;
}

Cell plain_cell(std::string_view line, std::size_t begin, std::size_t end) {
  const auto whole = line.substr(begin, end - begin);
  const auto text = trimmed(whole);
  const auto offset = text.empty() ? 0 : static_cast<std::size_t>(text.data() - whole.data());
  return {text, begin + offset + 1};
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string_view without_mark(std::string_view text) {
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

std::string_view not_utf8(std::string_view text) {
  if (text.starts_with("PK\x03\x04") || text.starts_with("\xd0\xcf\x11\xe0"))
    return "a workbook; save it as CSV in UTF-8";
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") ||
      text.substr(0, kLooked).find('\0') != std::string_view::npos) {
    return "UTF-16; save it as CSV in UTF-8 (iconv -f UTF-16 -t UTF-8)";
  }
  return {};
}

char separator_of(std::string_view header) {
  for (const char separator : {';', '\t'})
    if (header.find(separator) != std::string_view::npos) return separator;
  return ',';
}

std::optional<std::vector<Cell>> split(std::string_view line, char separator) {
  std::vector<Cell> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    std::size_t first = line.find_first_not_of(" \r", begin);
    std::size_t behind = begin;  // a cell in quotes
    if (first != std::string_view::npos && line[first] == '"') {
      const auto cell = quoted_cell(line, first, behind);
      if (!cell) return std::nullopt;
      cells.push_back(*cell);
    }
    const auto end = std::min(line.find(separator, behind), line.size());
    if (behind == begin) cells.push_back(plain_cell(line, begin, end));
    begin = end + 1;
  }
  return cells;
}

std::string unquoted(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    plain += text[i];
    if (text.substr(i).starts_with("\"\"")) ++i;
  }
  return plain;
}

std::optional<double> number_of(std::string_view text, char decimal) {
  std::array<char, 64> buffer{};
  if (decimal == ',' && text.size() <= buffer.size() && text.find('.') == std::string_view::npos) {
    std::replace_copy(text.begin(), text.end(), buffer.begin(), ',', '.');
    text = {buffer.data(), text.size()};
  }
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

bool is_blank(std::string_view line) {
  const auto text = trimmed(line);
  return text.find_first_not_of(",;\t ") == std::string_view::npos || text.front() == '#' || text.front() == '%' ||
         text.starts_with("//");
}

}  // namespace acus::client
