// SPDX-License-Identifier: GPL-3.0-or-later
// Tetrahedra that a mesh file puts together: a physical group of Gmsh, a reference of Medit, a property of Nastran, a
// value of an integer cell array of VTK, an element set of Abaqus. A tetrahedron may be in several, or in none.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace acus {

struct MeshGroup {
  std::string array;                   // name of the cell array whose value `number` is; empty in other formats
  std::optional<std::int64_t> number;  // none where the file knows the group by name alone
  std::string name;                    // empty where it has none
  std::vector<int> members;            // ascending numbers of its tetrahedra

  // "3 (skull)", "region 3", "skull".
  std::string label() const {
    if (!number) return name;
    const std::string plain = (array.empty() ? "" : array + " ") + std::to_string(*number);
    return name.empty() ? plain : plain + " (" + name + ")";
  }
  // By name, number, or array and number.
  bool answers_to(const std::string& text) const {
    if (!name.empty() && text == name) return true;
    return number && (text == std::to_string(*number) || text == array + " " + std::to_string(*number));
  }
  bool operator==(const MeshGroup&) const = default;
};

}  // namespace acus
