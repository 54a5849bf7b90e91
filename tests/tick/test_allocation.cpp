// SPDX-License-Identifier: GPL-3.0-or-later
// A tick asks for no memory, for no lock and for nothing of the kernel: each can wait for another thread or give the
// processor to somebody else, and a deadline is missed.
#include <doctest/doctest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <mutex>

#include "tests/study/bench/allocation_count.h"
#include "tests/tick/lock_count.h"
#include "tests/tick/sealed.h"
#include "tests/tick/to_and_fro.h"

namespace acus::test {
namespace {

TEST_CASE("allocations are counted") {
  const AllocationCount count;
  void* volatile from_malloc = std::malloc(100);
  const auto matrix = MatrixX(MatrixX::Zero(10, 10));
  const int counted = count.value();
  std::free(from_malloc);
  CHECK(matrix.isZero());
  CHECK(counted == 2);
}

TEST_CASE("memory given back is counted, nothing given back is not") {
  void* volatile memory = std::malloc(100);
  const AllocationCount count;
  std::free(memory);
  std::free(nullptr);
  const int counted = count.value();
  CHECK(counted == 1);
}

TEST_CASE("locks are counted") {
  std::mutex mutex;
  int counted = 0;
  {
    const LockCount count;
    const std::lock_guard lock(mutex);
    counted = count.value();
  }
  CHECK(counted == 1);
}

bool can_watch_kernel() {
  static const bool can = run_sealed([] {}).watched;
  return can;
}

TEST_CASE("a system call is noticed, and which") {
  if (!can_watch_kernel()) return;
  const Sealed sealed = run_sealed([] { static_cast<void>(getppid()); });
  CHECK(sealed.watched);
  CHECK(sealed.system_call == SYS_getppid);
}

struct Counts {
  int ticks = 0, allocations = 0, locks = 0;
};

void check_scene(const ScannedScene& watched) {
  for_each_way(watched, [&](Simulation& simulation) {
    const SharedWithChild<Counts> counts;
    const auto run = [&] {
      to_and_fro(simulation, watched.depth, [&] {
        const AllocationCount allocation_count;
        const LockCount lock_count;
        simulation.step();
        ++counts->ticks;
        counts->allocations += allocation_count.value();
        counts->locks += lock_count.value();
      });
    };
    if (can_watch_kernel()) {
      const Sealed sealed = run_sealed(run);
      CHECK(sealed.watched);
      CHECK(sealed.system_call == -1);
    } else {
      MESSAGE("system calls are not watched: seccomp filters are not permitted here");
      run();
    }
    CHECK(counts->ticks > 0);
    CHECK(counts->allocations == 0);
    CHECK(counts->locks == 0);
  });
}

TEST_CASE("no tick of a deferred field allocates while states of two earlier windows are kept") {
  Simulation simulation(load_watched(kWatchedScenes[0], kWatchedWays.back()));
  REQUIRE(simulation.scene().tissue.window > 0);
  std::array<State, 2> kept{simulation.state(), simulation.state()};
  int ticks = 0, allocations = 0;
  to_and_fro(simulation, 0.02, [&] {
    const AllocationCount allocation_count;
    simulation.step();
    allocations += allocation_count.value();
    if (++ticks % 20 == 0) kept[static_cast<std::size_t>(ticks / 20 % 2)] = simulation.state();
  });
  CHECK(ticks > 150);
  CHECK(allocations == 0);
}

TEST_CASE("no tick allocates, locks or calls the kernel: puncture, cutting, friction, withdrawal" *
          doctest::test_suite("full")) {
  check_scene(kWatchedScenes[0]);
}
TEST_CASE("no tick allocates, locks or calls the kernel: a bevel in its guide, with torsional friction" *
          doctest::test_suite("gate")) {
  check_scene(kWatchedScenes[1]);
}
TEST_CASE("no tick allocates, locks or calls the kernel: contact with an inclusion, and along it" *
          doctest::test_suite("full")) {
  check_scene(kWatchedScenes[2]);
}
TEST_CASE("no tick allocates, locks or calls the kernel: out on the other side and back" *
          doctest::test_suite("gate")) {
  check_scene(kWatchedScenes[3]);
}
TEST_CASE("no tick allocates, locks or calls the kernel: a rigid needle" * doctest::test_suite("gate")) {
  check_scene(kWatchedScenes[4]);
}
TEST_CASE("no tick allocates, locks or calls the kernel: two needles" * doctest::test_suite("gate")) {
  check_scene(kWatchedScenes[5]);
}
TEST_CASE("no tick allocates, locks or calls the kernel: bases on springs" * doctest::test_suite("gate")) {
  check_scene(kWatchedScenes[6]);
  check_scene(kWatchedScenes[7]);
}
TEST_CASE("no tick allocates, locks or calls the kernel: nodal pressures in two regions" *
          doctest::test_suite("gate")) {
  check_scene(kWatchedScenes[8]);
}
TEST_CASE("no tick allocates, locks or calls the kernel: points of the mesh without springs in series" *
          doctest::test_suite("full")) {
  check_scene(kWatchedScenes[9]);
}
TEST_CASE("no tick allocates, locks or calls the kernel: tissue that relaxes, friction that thins" *
          doctest::test_suite("gate")) {
  check_scene(kWatchedScenes[10]);
}

}  // namespace
}  // namespace acus::test
