// SPDX-License-Identifier: GPL-3.0-or-later
// How libFuzzer changes scenes: bytes alone seldom make another number that a scene may have.
#include <cmath>
#include <cstring>
#include <random>
#include <regex>
#include <string>

#include "tests/fuzz/fuzz.h"

namespace {

using Random = std::minstd_rand;

// Mostly of an odd size.
std::string any_number(Random& random) {
  const double exponent = std::uniform_real_distribution(-12.0, 12.0)(random);
  const int digits = std::uniform_int_distribution(0, 3)(random);
  char text[32];
  std::snprintf(text, sizeof text, "%s%.*g", random() % 4 == 0 ? "-" : "", digits + 1, std::pow(10, exponent));
  return random() % 8 == 0 ? "0" : text;
}

// With another number in place of one.
std::string renumbered(std::string text, Random& random) {
  static const std::regex number(R"([-+]?\b[0-9]+(\.[0-9]*)?([eE][-+]?[0-9]+)?|[-+]?\.inf)");
  const std::sregex_iterator begin(text.begin(), text.end(), number);
  const auto count = std::distance(begin, std::sregex_iterator());
  if (count == 0) return text;
  const std::smatch found = *std::next(begin, std::uniform_int_distribution<std::ptrdiff_t>(0, count - 1)(random));
  const auto at = static_cast<std::size_t>(found.position()), length = static_cast<std::size_t>(found.length());
  return text.replace(at, length, any_number(random));
}

}  // namespace

// Given by libFuzzer.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

// Bytes alone seldom make another number that a scene may have.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  Random random(seed);
  if (random() % 3 == 0) return LLVMFuzzerMutate(data, size, most);
  const std::string text = renumbered(std::string(acus::fuzz::text_of(data, size)), random).substr(0, most);
  std::memcpy(data, text.data(), text.size());
  return text.size();
}
