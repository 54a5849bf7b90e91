// SPDX-License-Identifier: GPL-3.0-or-later
// What is probably a mistake in a scene that can be used.
#pragma once

#include <string>
#include <vector>

namespace acus {

struct SceneWarning {
  std::string of;    // region, needle, guide or "tissue"
  std::string text;  // what is found, then a remedy
};

using SceneWarnings = std::vector<SceneWarning>;

}  // namespace acus
