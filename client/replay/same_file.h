// SPDX-License-Identifier: MIT
// Whether two paths lead to one file, also where it is not there yet: what is read must not be written over.
#pragma once

#include <string>

namespace acus::client {

// Links are followed, and two names of one file, which hard links make, are the same.
bool same_file(const std::string& a, const std::string& b);

}  // namespace acus::client
