// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/mesh_files/file_text.h"

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

template <class Number>
std::optional<Number> parse(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string_view without_plus(std::string_view text) {
  return text.size() > 1 && text[0] == '+' && text[1] != '-' ? text.substr(1) : text;
}

// "1.5D-3" and "1.5-3" as "1.5e-3".
std::string with_usual_exponent(std::string_view text) {
  std::string usual(text);
  const std::size_t letter = usual.find_first_of("dD");
  const std::size_t sign = usual.find_first_of("+-", 1);
  if (letter != std::string::npos)
    usual[letter] = 'e';
  else if (sign != std::string::npos)
    usual.insert(sign, 1, 'e');
  const std::size_t plus = usual.find("e+");
  if (plus != std::string::npos) usual.erase(plus + 1, 1);
  return usual;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

std::string in_capitals(std::string_view text) {
  std::string capitals(text);
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return capitals;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(trimmed(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kShown = 40;
  return '"' + std::string(text.substr(0, kShown)) + (text.size() > kShown ? "...\"" : "\"");
}

std::optional<std::int64_t> parse_integer(std::string_view text) { return parse<std::int64_t>(without_plus(text)); }

std::optional<double> parse_real(std::string_view text) {
  text = without_plus(text);
  const std::optional<double> value = parse<double>(text);
  return value || text.empty() ? value : parse<double>(with_usual_exponent(text));
}

void FileText::skip_spaces() {
  while (at_ < bytes_.size()) {
    if (comment_ != 0 && bytes_[at_] == comment_)
      at_ = std::min(bytes_.find('\n', at_), bytes_.size());
    else if (kSpaces.find(bytes_[at_]) == std::string_view::npos)
      return;
    else
      ++at_;
  }
}

std::string_view FileText::peek() {
  skip_spaces();
  const std::size_t end = bytes_.find_first_of(kSpaces, at_);
  return bytes_.substr(at_, end == std::string_view::npos ? end : end - at_);
}

std::string_view FileText::word(const char* expected) {
  const std::string_view next = peek();
  word_at_ = at_;
  if (next.empty()) fail(std::string("expected ") + expected + ", found the end of the file");
  at_ += next.size();
  return next;
}

void FileText::expect(std::string_view expected, const char* why) {
  const std::string_view found = word(why);
  if (found != expected) fail("expected " + std::string(expected) + ", " + why + ", found " + in_quotes(found));
}

std::int64_t FileText::integer(const char* what) {
  const std::string_view found = word(what);
  const std::optional<std::int64_t> value = parse_integer(found);
  if (!value) fail(std::string("expected ") + what + ", found " + in_quotes(found));
  return *value;
}

std::size_t FileText::count(const char* what) {
  const std::int64_t value = integer(what);
  if (value < 0) fail(std::string("expected ") + what + ", found " + std::to_string(value));
  return static_cast<std::size_t>(value);
}

double FileText::real(const char* what) {
  const std::string_view found = word(what);
  const std::optional<double> value = parse_real(found);
  if (!value || !std::isfinite(*value)) fail(std::string("expected ") + what + ", found " + in_quotes(found));
  return *value;
}

std::string_view FileText::line() {
  word_at_ = at_;
  const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
  std::string_view rest = bytes_.substr(at_, end - at_);
  at_ = std::min(end + 1, bytes_.size());
  if (rest.ends_with('\r')) rest.remove_suffix(1);
  return rest;
}

void FileText::expect_line_end(const char* after) {
  const std::size_t begin = at_;
  std::string_view rest = line();
  if (comment_ != 0) rest = rest.substr(0, rest.find(comment_));
  if (trimmed(rest).empty()) return;
  fail_at(begin, std::string("expected the end of the line after ") + after + ", found " + in_quotes(trimmed(rest)));
}

std::string_view FileText::take(std::size_t size, const char* what) {
  if (size > left()) {
    throw MeshError(std::string("expected ") + what + " (" + std::to_string(size) + " bytes from byte " +
                    std::to_string(at_) + "), found the end of the file; it is cut off");
  }
  word_at_ = at_;
  at_ += size;
  return bytes_.substr(at_ - size, size);
}

void FileText::go_to(std::size_t at) { at_ = std::min(at, bytes_.size()); }

std::string FileText::place(std::size_t at) const {
  const auto end = bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(at, bytes_.size()));
  if (std::find(bytes_.begin(), end, '\0') != end) return "byte " + std::to_string(at);
  return "line " + std::to_string(1 + std::count(bytes_.begin(), end, '\n'));
}

void FileText::fail_at(std::size_t at, const std::string& what) const { throw MeshError(place(at) + ": " + what); }

}  // namespace acus
