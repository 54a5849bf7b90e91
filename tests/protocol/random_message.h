// SPDX-License-Identifier: GPL-3.0-or-later
// Random messages and their comparison, both by walking the field lists, so that a new message or field is covered
// without a line here.
#pragma once

#include <cmath>
#include <random>
#include <type_traits>

#include "protocol/codec.h"

namespace acus::protocol::testing {

using Random = std::mt19937_64;

struct FillField {
  Random& random;

  void operator()(const char*, bool& value) { value = random() % 2 == 0; }
  void operator()(const char*, double& value) { value = std::uniform_real_distribution<double>(-1e3, 1e3)(random); }
  void operator()(const char*, float& value) { value = std::uniform_real_distribution<float>(-1e3f, 1e3f)(random); }
  void operator()(const char*, std::int32_t& value) { value = static_cast<std::int32_t>(random()); }
  void operator()(const char*, std::uint8_t& value) { value = static_cast<std::uint8_t>(random()); }
  void operator()(const char*, std::uint64_t& value) { value = random() >> (random() % 64); }
  void operator()(const char*, std::uint32_t& value) {
    value = static_cast<std::uint32_t>(random() >> (random() % 64));
  }

  void operator()(const char*, std::string& value) {
    value.resize(random() % 40);
    for (char& c : value) c = static_cast<char>('a' + random() % 26);
  }

  template <class Enum>
  requires std::is_enum_v<Enum>
  void operator()(const char*, Enum& value) { value = static_cast<Enum>(random() % names_of(Enum{}).size()); }

  void operator()(const char* name, Vector3& value) {
    for (double& x : value) (*this)(name, x);
  }

  void operator()(const char* name, Quaternion& value) {
    for (double* x : {&value.w, &value.x, &value.y, &value.z}) (*this)(name, *x);
    const double length = std::hypot(std::hypot(value.w, value.x), std::hypot(value.y, value.z));
    for (double* x : {&value.w, &value.x, &value.y, &value.z}) *x /= length;
  }

  template <class T>
  void operator()(const char* name, std::optional<T>& value) {
    value.reset();
    if (random() % 2 == 0) (*this)(name, value.emplace());
  }

  template <class T>
  void operator()(const char* name, std::vector<T>& value) {
    value.resize(random() % 9);
    for (T& element : value) (*this)(name, element);
  }

  template <class T>
  requires requires(T& fielded, FillField fill) { T::fields(fielded, fill); }
  void operator()(const char*, T& value) { T::fields(value, *this); }
};

// Ranges that the field types alone do not say.
template <class Message>
void bring_into_range(Message&) {}
inline void bring_into_range(Step& step) { step.ticks = 1 + step.ticks % kMaxStepTicks; }
inline void bring_into_range(Pose& pose) {
  pose.seq |= 1;
  for (double& x : pose.position) x = std::remainder(x, kMaxPosition);
}
inline void bring_into_range(Spin& spin) { spin.seq |= 1; }

template <class Message>
Message random_message(Random& random) {
  Message message;
  Message::fields(message, FillField{random});
  bring_into_range(message);
  return message;
}

// Calls visit(message) with a random message of each alternative of the variant.
template <class Variant, class Visit, std::size_t... I>
void for_each_message(Random& random, Visit&& visit, std::index_sequence<I...>) {
  (visit(random_message<std::variant_alternative_t<I, Variant>>(random)), ...);
}
template <class Variant, class Visit>
void for_each_message(Random& random, Visit&& visit) {
  for_each_message<Variant>(random, visit, std::make_index_sequence<std::variant_size_v<Variant>>());
}

inline Command decode_as(std::string_view bytes, const Command*) { return decode_command(bytes); }
inline Reply decode_as(std::string_view bytes, const Reply*) { return decode_reply(bytes); }
inline State decode_as(std::string_view bytes, const State*) { return decode_state(bytes); }

// Decodes as one of Command, Reply or State.
template <class Variant>
Variant decode(std::string_view bytes) {
  return decode_as(bytes, static_cast<const Variant*>(nullptr));
}

}  // namespace acus::protocol::testing
