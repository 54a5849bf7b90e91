// SPDX-License-Identifier: GPL-3.0-or-later
// Where this build's programs and sources are. Only places.cpp is compiled with these folders: a command line that held
// them would be another one in every clone, and a compiler cache would find nothing.
#pragma once

#include <string>

namespace acus {

// Absolute path of a file or folder of the sources, for instance "scenes/bone.yaml".
std::string source_path(const std::string& below);

// Absolute path of a program of this build, for instance "acus-server".
std::string program_path(const std::string& name);

}  // namespace acus
