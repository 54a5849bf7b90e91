// SPDX-License-Identifier: GPL-3.0-or-later
// What of a needle crosses tissue that does not hold it.
#include <doctest/doctest.h>

#include "server/engine/tick/insertion/held_stretch.h"
#include "server/engine/tick/insertion/transitions/shaft_monitor.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

// Ticks in which the whole needle is looked at.
constexpr int kTicks = static_cast<int>(kMonitorPeriod / kH);

double unheld(InsertionBench& bench) {
  ShaftMonitor monitor;
  for (int i = 0; i < kTicks; ++i) monitor_shaft(bench.view(), bench.scratch, bench.state, monitor);
  return monitor.unheld;
}

}  // namespace

TEST_CASE("a needle outside has nothing unheld") {
  InsertionBench bench;
  CHECK(unheld(bench) == 0);
  bench.put_needle(Vector3(0.1, 0, kTop + 1e-3), Vector3::UnitX());  // along the surface
  CHECK(unheld(bench) == 0);
}

TEST_CASE("a shaft that crosses the tissue from side to side is told, to a sample") {
  InsertionBench bench;
  bench.put_needle(Vector3(0.05, 0.0021, 0.0032), Vector3::UnitX());  // the cube reaches from -30 to 30 mm
  CHECK(std::abs(unheld(bench) - 0.058) < 1.5 * kMonitorSpacing);     // less 1 mm at either face
}

TEST_CASE("what is in its path is held, what is beside it is not") {
  InsertionBench bench;
  bench.add_straight_path(0.010);
  bench.be_in_path(0);
  bench.put_needle(on_line(0.010));
  bench.state.depth = 0.020;
  CHECK(unheld(bench) == 0);
  bench.state.depth = 0.010;  // the other half has come in from elsewhere
  CHECK(std::abs(unheld(bench) - (0.009 - kHeldBeside / 2)) <= kMonitorSpacing);
}

TEST_CASE("what a surface has a contact with is held") {
  InsertionBench bench;
  bench.put_needle(Vector3(0.02, 0.0021, kTop - 2e-3), Vector3::UnitX());  // 50 mm of it under the top
  CHECK(unheld(bench) > 0.04);
  for (ShaftCell& cell : bench.state.cells) cell.length = 0.01;
  CHECK(unheld(bench) == 0);
}

TEST_CASE("a tip in contact may stand beyond the surface of the mesh by what gives way under it") {
  InsertionBench bench;
  bench.put_needle(on_line(kTop));
  bench.state.phase = Phase::contact;
  bench.state.touched = bench.point(on_line(kTop));
  bench.locate();
  bench.state.tip.contact.along = 0.3;
  bench.put_needle(on_line(kTop - 2e-3));
  CHECK(unheld(bench) == 0);
}

}  // namespace acus::test
