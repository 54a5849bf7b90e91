// SPDX-License-Identifier: GPL-3.0-or-later
// Writes down what scene_fields.h says: the JSON Schema for editors and the tables of docs/scene-fields.md.
#pragma once

#include <string>
#include <vector>

namespace acus {

// JSON Schema, draft 7, of a scene file; what scenes/scene.schema.json holds.
std::string scene_schema();

// One Markdown table per kind of map in a scene file: field, unit, default, range, meaning.
struct FieldTable {
  std::string title;
  std::string markdown;
};
std::vector<FieldTable> scene_tables();

}  // namespace acus
