// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings that were written by hand and run again.
#include "server/engine/recording/rerun.h"

#include <doctest/doctest.h>

#include "tests/support/recorded_run.h"
#include "tests/support/small_block.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

using Run = test::RecordedRun;

struct RunAgain {
  std::uint64_t ticks = 0;
  std::optional<Difference> difference;
  std::string problem;
};

RunAgain run_again(Run& run) {
  run.writer().flush();
  Rerun rerun(run.writer().path());
  while (rerun.step()) {
  }
  return {rerun.ticks(), rerun.difference(), rerun.problem()};
}

std::string error_of(Run& run) {
  try {
    run_again(run);
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("a run that is made again is the same, through the surface and back to an earlier state") {
  const TemporaryFolder folder;
  Run run(folder / "run");
  for (int i = 0; i < 200; ++i) run.tick(i % 50 > 40);
  run.state();
  CHECK(run.simulation().report().needles[0].phase == Phase::inside);
  const State state = run.simulation().state();
  for (int i = 0; i < 20; ++i) run.tick();
  run.simulation().restore(state);
  run.begin(1);
  for (int i = 0; i < 20; ++i) run.tick();
  run.state();
  run.writer().add(recorded::Ending{""});
  const RunAgain out = run_again(run);
  CHECK(out.ticks == 240);
  CHECK(!out.difference);
  CHECK(out.problem.empty());
}

TEST_CASE("the first tick that comes out otherwise is named") {
  const TemporaryFolder folder;
  Run run(folder / "run");
  for (int i = 0; i < 5; ++i) run.tick();
  run.go_wrong();
  for (int i = 0; i < 5; ++i) run.tick();
  const RunAgain out = run_again(run);
  CHECK(out.ticks == 10);
  REQUIRE(out.difference);
  CHECK(out.difference->tick == 6);
  CHECK(out.difference->reported);
  CHECK(out.problem.starts_with("it was not ended"));
}

TEST_CASE("a state that comes out otherwise is told, too") {
  const TemporaryFolder folder;
  Run run(folder / "run");
  run.tick();
  run.go_wrong();
  run.state();
  run.go_right();
  run.tick();
  const RunAgain out = run_again(run);
  REQUIRE(out.difference);
  CHECK(out.difference->tick == 1);
  CHECK(!out.difference->reported);
}

TEST_CASE("what cannot be run again is refused with a sentence") {
  const TemporaryFolder folder;
  SUBCASE("a body that the scene does not have") {
    Run run(folder / "run");
    run.writer().add(recorded::BodyCommand{1, {}});
    CHECK(error_of(run) == "the recording commands a needle or guide that its scene does not have");
  }
  SUBCASE("a command out of range") {
    Run run(folder / "run");
    run.writer().add(
        recorded::BodyCommand{0, {.seq = 1, .pose = Pose{{1e300, 0, 0}, Quaternion::Identity()}, .spin = {}}});
    CHECK(error_of(run) == "the recording has a command that is out of range");
  }
  SUBCASE("a snapshot of something else") {
    Run run(folder / "run");
    run.writer().add(recorded::Beginning{1, std::vector<std::byte>(100)});
    CHECK(error_of(run).starts_with("a state of the recording cannot be used: "));
  }
  SUBCASE("a scene that means something else") {
    Run run(folder / "run");
    run.writer().add(recorded::World{"small.yaml", test::small_block().text, 500, 1, {}});
    CHECK(error_of(run).starts_with("the scene in the recording means something else"));
  }
  SUBCASE("a mesh that is none") {
    Run run(folder / "run");
    TetrahedralMesh mesh;
    mesh.nodes = Matrix3X::Zero(3, 2);
    mesh.tetrahedra = {{0, 1, 2, 1 << 30}};
    run.writer().add(recorded::World{"small.yaml", test::small_block().text, 500, 1, mesh});
    CHECK(error_of(run).starts_with("the mesh in the recording cannot be used: "));
  }
  SUBCASE("ticks of a scene that never began") {
    Run run(folder / "run");
    run.writer().add(record_of(test::small_block(), {}, run.simulation().model().fingerprint));
    run.writer().add(recorded::Tick{1, 1, false});
    CHECK(error_of(run) == "the recording has ticks before a state to begin with");
  }
}

}  // namespace acus
