// SPDX-License-Identifier: GPL-3.0-or-later
// Inputs that are right, for a fuzzer to begin with: one or more of each kind that the program reads.
#pragma once

#include <string>
#include <vector>

namespace acus::fuzz {

// Of the target with that name; throws std::runtime_error if there is none.
std::vector<std::string> samples(const std::string& target);

}  // namespace acus::fuzz
