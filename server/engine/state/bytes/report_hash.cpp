// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/bytes/report_hash.h"

#include <string_view>

namespace acus {

namespace {

// Numbers one after the other: structs as a whole would bring padding along.
template <class Number>
void add_number(Hasher& hasher, Number number) {
  static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
  hasher.bytes(&number, sizeof number);
}

template <class Derived>
void add_matrix(Hasher& hasher, const Eigen::MatrixBase<Derived>& matrix) {
  for (Eigen::Index j = 0; j < matrix.cols(); ++j)
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) add_number(hasher, matrix(i, j));
}

// Adds every field in its order.
struct Adder {
  Hasher& hasher;

  template <class T>
  void operator()(const char*, const T& value) {
    visit(value);
  }
  // Follows from the state and the command, and is left out, so that hashes of older runs hold.
  void operator()(const char* name, const Pose& pose) {
    if (std::string_view(name) == "commanded") return;
    add_matrix(hasher, pose.orientation.coeffs());
    add_matrix(hasher, pose.position);
  }

  template <class T>
  void visit(const T& value) {
    if constexpr (requires { T::fields(value, *this); }) {
      T::fields(value, *this);
    } else if constexpr (requires { value.derived(); }) {
      add_matrix(hasher, value);
    } else {
      add_number(hasher, value);
    }
  }
  template <class T>
  void visit(const std::vector<T>& list) {
    for (const T& item : list) visit(item);
  }
};

}  // namespace

void add_report(Hasher& hasher, const TickReport& report) { TickReport::fields(report, Adder{hasher}); }

}  // namespace acus
