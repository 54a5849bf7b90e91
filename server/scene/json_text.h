// SPDX-License-Identifier: GPL-3.0-or-later
// Just enough JSON to write a schema or the results of a measurement: values are texts, objects keep the order of their members.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace acus {

using JsonMembers = std::vector<std::pair<std::string, std::string>>;  // name, JSON value

std::string json_string(const std::string& text);
std::string json_array(const std::vector<std::string>& values);
std::string json_object(const JsonMembers& members);

// The same value with one member per line, two spaces deeper for each object; arrays stay on their line.
std::string indent_json(const std::string& json);

}  // namespace acus
