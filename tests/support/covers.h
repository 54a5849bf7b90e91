// SPDX-License-Identifier: GPL-3.0-or-later
// Whether the fields() of a struct names all that it holds, by where they lie: between two of them, and behind the
// last, there is no more room than alignment asks for. A bool that is left out may hide there; anything larger does
// not.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace acus::test {

// What is wrong: the field before the gap; empty if nothing is.
template <class T>
std::string gap_in_fields() {
  struct Field {
    std::string name;
    std::size_t begin, size, alignment;
  };
  const auto up = [](std::size_t to, std::size_t alignment) { return (to + alignment - 1) / alignment * alignment; };
  const T value{};
  std::vector<Field> found;
  T::fields(value, [&]<class Member>(const char* name, const Member& member) {
    const auto begin = reinterpret_cast<const std::byte*>(&member) - reinterpret_cast<const std::byte*>(&value);
    found.push_back({name, static_cast<std::size_t>(begin), sizeof(Member), alignof(Member)});
  });
  std::ranges::sort(found, {}, &Field::begin);
  std::string before = "nothing";
  std::size_t end = 0;
  for (const Field& field : found) {
    if (field.begin != up(end, field.alignment)) return before;
    before = field.name;
    end = field.begin + field.size;
  }
  return up(end, alignof(T)) == sizeof(T) ? "" : before;
}

}  // namespace acus::test
