// SPDX-License-Identifier: GPL-3.0-or-later
// Measured data that lies beside the sources, where somebody has put it: ../shared/data.
#pragma once

#include <filesystem>
#include <iostream>
#include <string>

#include "tests/support/places.h"

namespace acus {

// CTest tells a test as skipped that prints this, whatever it checks besides (tests/CMakeLists.txt): print it before
// the first check and return.
inline void print_skipped(const std::string& why) { std::cout << "SKIPPED: " << why << std::endl; }

// Path of a file of ../shared/data; empty where it is not, and the test is told as skipped.
inline std::string shared_data(const std::string& name) {
  const auto path = std::filesystem::path(source_path("../shared/data")) / name;
  if (std::filesystem::exists(path)) return std::filesystem::canonical(path).string();
  print_skipped("../shared/data/" + name + " is not beside the sources");
  return "";
}

}  // namespace acus
