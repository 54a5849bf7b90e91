// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes that are found by their names: those of the administrator, and those that were installed with the program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace acus {

// /etc/acus, then the scenes' folder of the installation that this program belongs to.
std::vector<std::filesystem::path> installed_scene_folders();

// The file that `scene` on a command line means: the file of that name, else NAME.yaml in the first of the folders that
// has it. Where nothing is found it is `scene` itself, which the reader of scenes then says cannot be opened.
std::string find_scene(const std::string& scene, const std::vector<std::filesystem::path>& folders);

}  // namespace acus
