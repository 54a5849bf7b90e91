// SPDX-License-Identifier: GPL-3.0-or-later
// A tick asks for no memory: an allocation can wait for a lock or for the kernel, and a deadline is missed. Counted by
// standing in for malloc, which operator new, Eigen and CHOLMOD all end in.
#include <doctest/doctest.h>

#include <atomic>
#include <cstdlib>

#include "server/simulation/simulation.h"

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
}

namespace {

std::atomic<bool> counting = false;
std::atomic<int> allocations = 0;

void count() {
  if (counting.load(std::memory_order_relaxed)) ++allocations;
}

}  // namespace

extern "C" {
void* malloc(std::size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
  count();
  return __libc_calloc(number, size);
}
void* realloc(void* old, std::size_t size) {
  count();
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  count();
  *result = __libc_memalign(alignment, size);
  return *result == nullptr;
}
}

namespace acus {
namespace {

// The base of the first needle goes `depth` (m) down and back at 40 mm/s, spinning; returns what the ticks allocated.
int allocations_of(const std::string& scene_name, double depth) {
  Simulation simulation(read_scene(std::string(ACUS_SOURCE_DIR) + "/scenes/" + scene_name + ".yaml"));
  const Pose base = simulation.scene().needles[0].base;
  const Vector3 axis = base.orientation * Vector3::UnitX();
  const double step = 0.04 / simulation.scene().rate;
  const int ticks = static_cast<int>(depth / step);
  int sum = 0;
  for (int tick = 0; tick < 2 * ticks; ++tick) {
    const double at = step * (tick < ticks ? tick : 2 * ticks - tick);
    simulation.command(0, {1, Pose{base.position + at * axis, base.orientation}, 1e-3 * tick});
    allocations = 0;
    counting = true;
    simulation.step();
    counting = false;
    sum += allocations;
  }
  return sum;
}

TEST_CASE("the counter counts") {
  allocations = 0;
  counting = true;
  void* volatile from_malloc = std::malloc(100);
  const auto matrix = MatrixX(MatrixX::Zero(10, 10));
  counting = false;
  std::free(from_malloc);
  CHECK(matrix.isZero());
  CHECK(allocations == 2);
}

TEST_CASE("no tick allocates: puncture, cutting, friction, withdrawal") {
  CHECK(allocations_of("insertion_pullback", 0.05) == 0);
}
TEST_CASE("no tick allocates: a bevel in its guide, with torsional friction") {
  CHECK(allocations_of("steering", 0.06) == 0);
}
TEST_CASE("no tick allocates: contact with an inclusion, and along it") {
  CHECK(allocations_of("inclusion_soft_needle", 0.06) == 0);
}
TEST_CASE("no tick allocates: out on the other side and back") { CHECK(allocations_of("through", 0.06) == 0); }

}  // namespace
}  // namespace acus
