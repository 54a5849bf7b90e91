// SPDX-License-Identifier: GPL-3.0-or-later
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/tick/bench.h"

namespace acus::test {

TEST_CASE("loading tells its steps in order") {
  std::vector<std::string> steps;
  const Simulation simulation(block_scene(), [&](const char* what) { steps.emplace_back(what); });
  const std::vector<std::string> expected{"mesh", "regions", "elements", "surfaces", "factor", "needles", "rows"};
  CHECK(steps == expected);
}

}  // namespace acus::test
