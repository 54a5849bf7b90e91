// SPDX-License-Identifier: GPL-3.0-or-later
// How the fields of a parameter struct are described: one list per struct, FieldsOf<Struct>::list, drives reading,
// range checks, the JSON Schema, the reference tables and their tests.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace acus {

// What a field may hold: the value of a number (each one of a vector), the characters of a text, the entries of a list.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool infinity_allowed = false;  // .inf beside the range, and -.inf where min is below zero

  bool contains(double value) const;
};

constexpr Range any() { return {}; }
constexpr Range between(double min, double max) {
  Range range;
  range.min = min;
  range.max = max;
  return range;
}
constexpr Range within(double most) { return between(-most, most); }
constexpr Range or_infinite(Range range) {
  range.infinity_allowed = true;
  return range;
}

// "in [0, 0.5]", "in [0, 1000] or .inf"; empty where everything finite is allowed.
std::string describe(const Range& range);

// The shortest text that reads back as the same number; ".inf" and "-.inf" as YAML writes them.
std::string format_number(double value);

// One field of Struct. `unit` is "-" for a pure number and empty for what is no number.
template <class Struct, class Value>
struct Field {
  const char* name;
  Value Struct::*member;
  const char* unit;
  Range range;
  const char* meaning;
};
// C++20 deduces it for aggregates; clang before version 17 does not.
template <class Struct, class Value>
Field(const char*, Value Struct::*, const char*, Range, const char*) -> Field<Struct, Value>;

// Fields of the same Struct that stand one level deeper in the file under `name`, exactly one of them at a time.
template <class... Fields>
struct Choice {
  const char* name;
  const char* meaning;
  std::tuple<Fields...> alternatives;
};
template <class... Fields>
Choice(const char*, const char*, std::tuple<Fields...>) -> Choice<Fields...>;

template <class... Fields>
constexpr Choice<Fields...> choice(const char* name, const char* meaning, Fields... fields) {
  return {name, meaning, {fields...}};
}

// Specialised per struct with `title` and `list`, a tuple of Field and Choice.
template <class Struct>
struct FieldsOf;

// Specialised per enum with `names`, in the order of its values.
template <class Enum>
struct NamesOf;

template <class Enum>
constexpr const char* name_of(Enum value) {
  return NamesOf<Enum>::names[static_cast<std::size_t>(value)];
}

template <class T>
concept HasFields = requires {
  FieldsOf<T>::list;
};

template <class T>
inline constexpr bool is_choice = false;
template <class... Fields>
inline constexpr bool is_choice<Choice<Fields...>> = true;

template <class T>
inline constexpr bool is_list = false;
template <class T>
inline constexpr bool is_list<std::vector<T>> = true;

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

// Calls visit(field) for every entry of a tuple of fields, in order.
template <class Tuple, class Visit>
void for_each_entry(const Tuple& fields, Visit&& visit) {
  std::apply([&visit](const auto&... field) { (visit(field), ...); }, fields);
}

}  // namespace acus
