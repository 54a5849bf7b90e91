// SPDX-License-Identifier: GPL-3.0-or-later
// The table's cases: enough of them, each what it says.
#include "tests/study/studies/stability_cases.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "tests/study/studies/stability_mesh.h"
#include "tests/support/temporary_folder.h"

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
  const TemporaryFolder meshes;
  for (const StabilityCase& c : stability_cases()) {
    if (c.refuse) continue;
    CAPTURE(c.name);
    CHECK_NOTHROW(validate(make_experiment(make_trial({&c, nullptr}), meshes.path()).scene));
  }
}

TEST_CASE("the quick table has 20 to 30 runs, pairs, every rung, and one that is refused") {
  const auto runs = quick_stability_runs();
  CHECK(runs.size() >= 20);
  CHECK(runs.size() <= 30);
  CHECK(std::ranges::count_if(runs, is_refused) == 1);
  CHECK(std::ranges::any_of(runs, [](const StabilityRun& run) { return run.partner != nullptr; }));
  std::set<TissueRung> rungs;
  for (const StabilityRun& run : runs) rungs.insert(make_trial(run).scene.tissue.rung);
  CHECK(rungs.size() == 4);
}

TEST_CASE("a needle spins while it is at depth, even if it got there at once") {
  const StabilityRun run{&stability_case("50 turns a second"), &stability_case("entry and exit in one tick")};
  const Experiment experiment = make_experiment(make_trial(run), "");
  const auto& samples = experiment.motion.motions[0].samples;
  CHECK(*samples.back().pose.spin - *samples.front().pose.spin > 5 * 2 * std::numbers::pi);
}

TEST_CASE("the case of vertices hits one whatever the cells are") {
  for (const char* mesh : {"base", "spacing 0.5 mm on 20 mm"}) {
    CAPTURE(mesh);
    const Trial trial = make_trial({&stability_case(mesh), &stability_case("through vertices along edges")});
    const BoxMesh& box = trial.scene.tissue.box;
    const Matrix3X nodes = make_box_mesh(box.size, box.cells).nodes;
    CHECK((nodes.colwise() - trial.approaches[0].at).colwise().norm().minCoeff() < 1e-12);
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
