// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/math/factor/panel_tree.h"

#include <algorithm>

namespace acus {

PanelTree make_panel_tree(int panel_count, const int* super, const int* row_start, const int* rows) {
  PanelTree tree;
  for (int s = 0; s < panel_count; ++s) {
    const int columns = super[s + 1] - super[s], all = row_start[s + 1] - row_start[s];
    const int* end = rows + row_start[s + 1];
    tree.panels.push_back({super[s], columns, all - columns, static_cast<int>(tree.rows.size()), -1, columns});
    tree.rows.insert(tree.rows.end(), end - (all - columns), end);
    tree.panel_of.insert(tree.panel_of.end(), columns, s);
    tree.widest = std::max(tree.widest, all);
  }
  tree.from_root.resize(tree.panel_of.size());
  for (int s = panel_count - 1; s >= 0; --s) {
    PanelTree::Panel& panel = tree.panels[s];
    if (panel.below > 0) panel.parent = tree.panel_of[tree.rows[panel.first_row]];
    if (panel.parent >= 0) panel.to_root += tree.panels[panel.parent].to_root;
    for (int i = 0; i < panel.columns; ++i) tree.from_root[panel.first + i] = panel.to_root - i;
    tree.longest_way = std::max(tree.longest_way, panel.to_root);
  }
  return tree;
}

}  // namespace acus
