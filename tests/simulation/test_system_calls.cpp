// SPDX-License-Identifier: GPL-3.0-or-later
// A tick does not call the kernel, which may take its time, or give the processor to somebody else.
#include <doctest/doctest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "tests/simulation/sealed.h"
#include "tests/simulation/to_and_fro.h"

namespace acus::test {
namespace {

bool can_watch() {
  if (run_sealed([] {}).watched) return true;
  MESSAGE("skipped: seccomp filters are not permitted here");
  return false;
}

TEST_CASE("a system call is noticed, and which") {
  if (!can_watch()) return;
  const Sealed sealed = run_sealed([] { static_cast<void>(getppid()); });
  CHECK(sealed.watched);
  CHECK(sealed.system_call == SYS_getppid);
}

void check_scene(const WatchedScene& watched) {
  if (!can_watch()) return;
  for_each_way(watched, [&](Simulation& simulation) {
    const Sealed sealed = run_sealed([&] { to_and_fro(simulation, watched.depth, [&] { simulation.step(); }); });
    CHECK(sealed.watched);
    CHECK(sealed.system_call == -1);
  });
}

TEST_CASE("no tick calls the kernel: puncture, cutting, friction, withdrawal") { check_scene(kWatchedScenes[0]); }
TEST_CASE("no tick calls the kernel: a bevel in its guide, with torsional friction") { check_scene(kWatchedScenes[1]); }
TEST_CASE("no tick calls the kernel: contact with an inclusion, and along it") { check_scene(kWatchedScenes[2]); }
TEST_CASE("no tick calls the kernel: out on the other side and back") { check_scene(kWatchedScenes[3]); }
TEST_CASE("no tick calls the kernel: a rigid needle") { check_scene(kWatchedScenes[4]); }
TEST_CASE("no tick calls the kernel: two needles") { check_scene(kWatchedScenes[5]); }
TEST_CASE("no tick calls the kernel: nodal pressures in two regions") { check_scene(kWatchedScenes[6]); }

}  // namespace
}  // namespace acus::test
