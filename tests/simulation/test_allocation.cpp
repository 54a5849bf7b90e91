// SPDX-License-Identifier: GPL-3.0-or-later
// A tick asks for no memory and for no lock: both can wait for another thread or for the kernel, and a deadline is
// missed.
#include <doctest/doctest.h>

#include <cstdlib>
#include <mutex>

#include "server/tools/bench/allocation_count.h"
#include "tests/simulation/lock_count.h"
#include "tests/simulation/to_and_fro.h"

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

void check_scene(const WatchedScene& watched) {
  for_each_way(watched, [&](Simulation& simulation) {
    int allocations = 0, locks = 0;
    to_and_fro(simulation, watched.depth, [&] {
      const AllocationCount allocation_count;
      const LockCount lock_count;
      simulation.step();
      allocations += allocation_count.value();
      locks += lock_count.value();
    });
    CHECK(allocations == 0);
    CHECK(locks == 0);
  });
}

TEST_CASE("no tick allocates or locks: puncture, cutting, friction, withdrawal") { check_scene(kWatchedScenes[0]); }
TEST_CASE("no tick allocates or locks: a bevel in its guide, with torsional friction") {
  check_scene(kWatchedScenes[1]);
}
TEST_CASE("no tick allocates or locks: contact with an inclusion, and along it") { check_scene(kWatchedScenes[2]); }
TEST_CASE("no tick allocates or locks: out on the other side and back") { check_scene(kWatchedScenes[3]); }
TEST_CASE("no tick allocates or locks: a rigid needle") { check_scene(kWatchedScenes[4]); }
TEST_CASE("no tick allocates or locks: two needles") { check_scene(kWatchedScenes[5]); }
TEST_CASE("no tick allocates or locks: nodal pressures in two regions") { check_scene(kWatchedScenes[6]); }
TEST_CASE("no tick allocates or locks: springs in series with all laws") { check_scene(kWatchedScenes[7]); }

}  // namespace
}  // namespace acus::test
