// SPDX-License-Identifier: GPL-3.0-or-later
// A block with a slot across it, as a Gmsh file: a needle that goes straight down leaves the tissue and meets it again.
#pragma once

#include <string>

namespace acus::test {

// 60 mm along each side around the origin, in cells of 10 mm x 10 mm x 5 mm (m). Its slot is `slot` (m) high around z = 0
// and open towards -x; the block is whole from x = 10 mm on.
std::string notched_block(double slot = 10e-3);

}  // namespace acus::test
