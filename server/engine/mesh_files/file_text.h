// SPDX-License-Identifier: GPL-3.0-or-later
// The bytes of a mesh file, read as words of a text or as binary numbers. Errors name the line, in binary parts the
// byte. Nothing is read beyond the end.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace acus {

constexpr std::string_view kSpaces = " \t\r\n\v\f";

std::string_view trimmed(std::string_view text);
std::string in_capitals(std::string_view text);
std::vector<std::string_view> split(std::string_view text, char separator);  // trimmed parts, empty ones too
std::string in_quotes(std::string_view text);                                // shortened

// The whole of `text` as a number, with Fortran's and Nastran's exponents ("1.5D-3", "1.5-3"); a sign "+" is taken.
std::optional<std::int64_t> parse_integer(std::string_view text);
std::optional<double> parse_real(std::string_view text);

class FileText {
 public:
  // From `comment` to the end of its line text is skipped; 0: there are no comments.
  explicit FileText(std::string_view bytes, char comment = 0) : bytes_(bytes), comment_(comment) {}

  // ---- Words, across lines
  std::string_view peek();                      // the next word, empty at the end of the file
  std::string_view word(const char* expected);  // the next word; throws at the end of the file
  void expect(std::string_view word, const char* why);
  std::int64_t integer(const char* what);
  std::size_t count(const char* what);      // an integer that is not negative
  double real(const char* what);            // a finite number
  std::string_view line();                  // the rest of the line, without its end
  void expect_line_end(const char* after);  // nothing but a comment stands before it

  // ---- Binary
  std::string_view take(std::size_t size, const char* what);
  template <class Number>
  Number binary(const char* what) {
    return number_at<Number>(take(sizeof(Number), what).data(), swapped_);
  }
  void swap_bytes(bool swapped) { swapped_ = swapped; }
  template <class Number>
  static Number number_at(const char* bytes, bool swapped);

  // ---- Places
  std::string_view bytes() const { return bytes_; }
  std::size_t at() const { return at_; }            // of the next byte
  std::size_t word_at() const { return word_at_; }  // of the word that was read last
  void go_to(std::size_t at);
  std::size_t left() const { return bytes_.size() - at_; }
  std::string place(std::size_t at) const;                                   // "line 12"
  [[noreturn]] void fail_at(std::size_t at, const std::string& what) const;  // throws MeshError
  [[noreturn]] void fail(const std::string& what) const { fail_at(word_at_, what); }

 private:
  void skip_spaces();

  std::string_view bytes_;
  std::size_t at_ = 0, word_at_ = 0;
  char comment_;
  bool swapped_ = false;
};

template <class Number>
Number FileText::number_at(const char* bytes, bool swapped) {
  std::array<char, sizeof(Number)> copy;
  std::memcpy(copy.data(), bytes, copy.size());
  if (swapped) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<Number>(copy);
}

}  // namespace acus
