// SPDX-License-Identifier: GPL-3.0-or-later
// The table's cases: enough of them, each what it says.
#include "server/study/stability_cases.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <set>

using namespace acus;

TEST_CASE("the table has 200 runs and more, each name once, and no pair turns one knob twice") {
  std::set<std::string> names;
  for (const StabilityCase& c : stability_cases()) CHECK(names.insert(c.name).second);
  const auto runs = stability_runs();
  CHECK(runs.size() >= 200);
  for (const StabilityRun& run : runs) {
    if (!run.partner) continue;
    for (const std::string& knob : run.first->knobs)
      CHECK(std::find(run.partner->knobs.begin(), run.partner->knobs.end(), knob) == run.partner->knobs.end());
  }
}

TEST_CASE("every case but the refused makes a scene that is valid") {
  for (const StabilityCase& c : stability_cases()) {
    if (c.refuse) continue;
    CAPTURE(c.name);
    CHECK_NOTHROW(
        validate(make_experiment(make_trial({&c, nullptr}), std::filesystem::temp_directory_path().string()).scene));
  }
}

TEST_CASE("slivers have the angle that was asked for, and volume") {
  for (const double degrees : {10.0, 3.0, 1.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    TetrahedralMesh mesh = make_box_mesh({0.06, 0.06, 0.06}, {5, 5, 5});
    distort_to_slivers(mesh, angle);
    CHECK(smallest_dihedral_angle(mesh) == doctest::Approx(angle).epsilon(1e-6));
    for (int t = 0; t < mesh.tetrahedron_count(); ++t) CHECK(rest_volume(mesh, t) > 0);
  }
}
