// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/mesh_files/mesh_contents.h"

#include <set>

namespace acus {

void MeshContents::add_element(const ElementType& type, std::int64_t number, std::size_t at,
                               std::span<const std::int64_t> its_nodes) {
  MeshElement element{number, at, type.shape, type.quadratic(), type.has_middles(), {}};
  const std::span<std::int64_t> kept = element.used_nodes();
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = its_nodes[type.order[i]];
  elements.push_back(element);
}

MeshGroup& GroupMaker::of(const std::string& array, std::int64_t number) {
  const auto [entry, is_new] = numbered_.try_emplace({array, number}, groups_.size());
  if (is_new) groups_.push_back({array, number, "", {}});
  return groups_[entry->second];
}

MeshGroup& GroupMaker::of(const std::string& name) {
  const auto [entry, is_new] = named_.try_emplace(name, groups_.size());
  if (is_new) groups_.push_back({"", std::nullopt, name, {}});
  return groups_[entry->second];
}

void add_groups_of_array(const std::string& array, std::span<const std::int64_t> values, MeshContents& contents) {
  constexpr std::size_t kMostValues = 1000;
  std::map<std::int64_t, std::vector<int>> members;
  for (std::size_t i = 0; i < values.size(); ++i) {
    members[values[i]].push_back(static_cast<int>(i));
    if (members.size() <= kMostValues) continue;
    contents.remarks.push_back("cell array " + in_quotes(array) + " has more than " + std::to_string(kMostValues) +
                               " values: too many to be groups");
    return;
  }
  for (auto& [value, elements] : members) contents.groups.push_back({array, value, "", std::move(elements)});
}

}  // namespace acus
