// SPDX-License-Identifier: GPL-3.0-or-later
// The shape of a supernodal Cholesky factor L. A panel (supernode) is a run of columns of L with the same rows below
// their triangle; its parent is the panel to which the first of these rows belongs, and all rows below a panel belong to
// panels on its way to the root of this elimination tree (Liu 1990, "The role of elimination trees in sparse
// factorization"). So L⁻¹ e, e a unit vector, is zero but on the way of its panel to the root, and such columns are
// stored as just that way, leaf first: two columns of one tree end with the same panels.
#pragma once

#include <vector>

namespace acus {

struct PanelTree {
  struct Panel {
    int first;      // position of the first column
    int columns;
    int below;      // rows below the triangle
    int first_row;  // of those, in `rows`
    int parent;     // -1: a root
    int to_root;    // entries of the way from here to the root: columns of this panel and of all above
  };

  std::vector<Panel> panels;   // children before parents
  std::vector<int> rows;       // positions of the rows below the panels
  std::vector<int> panel_of;   // per position
  std::vector<int> from_root;  // per position: entries of any way through it, from there to its end

  int longest_way = 0;  // entries
  int widest = 0;       // most rows of a panel, triangle included

  // The first panel that the ways of both share, -1 if they end in different roots.
  int meeting(int a, int b) const {
    while (a != b) {
      int& lower = a < b ? a : b;  // a parent comes after its children
      lower = panels[lower].parent;
      if (lower < 0) return -1;
    }
    return a;
  }
};

// From the arrays of a supernodal factor: panel s has the columns super[s] to super[s + 1] - 1, and all its rows, those
// of the triangle first, stand at rows[row_start[s]] to rows[row_start[s + 1] - 1] in rising order.
PanelTree make_panel_tree(int panel_count, const int* super, const int* row_start, const int* rows);

}  // namespace acus
