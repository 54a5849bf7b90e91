// SPDX-License-Identifier: GPL-3.0-or-later
// What is thrown where a scene, or a file that it names, cannot be used.
#pragma once

#include <stdexcept>

namespace acus {

// Something in a scene that cannot be used. what() reads "file:line:column: field: expected ..., found ...".
struct SceneError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace acus
