// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/insertion.h"

#include <algorithm>
#include <cmath>

namespace acus {

InsertionScratch::InsertionScratch(int shaft_capacity, int path_capacity, int shaft_cells, bool remembers)
    : next(make_insertion(path_capacity, shaft_cells, remembers)), turned(path_capacity) {
  located.contacts = Bounded<ShaftContact>(static_cast<std::size_t>(shaft_cells));
  located.shaft = Bounded<ShaftPoint>(static_cast<std::size_t>(shaft_capacity));
}

}  // namespace acus
