// SPDX-License-Identifier: GPL-3.0-or-later
// A member of a state or a report that its fields() leaves out would be in no snapshot, no hash and no digest.
#include <doctest/doctest.h>

#include "server/engine/state/report.h"
#include "server/engine/state/state.h"
#include "tests/support/covers.h"

namespace acus::test {

TEST_CASE("states and reports name all their members") {
  CHECK(gap_in_fields<State>() == "");
  CHECK(gap_in_fields<NeedleBalance>() == "");
  CHECK(gap_in_fields<TissueState>() == "");
  CHECK(gap_in_fields<FieldState>() == "");
  CHECK(gap_in_fields<FieldWindow>() == "");
  CHECK(gap_in_fields<HeldNode>() == "");
  CHECK(gap_in_fields<NeedleState>() == "");
  CHECK(gap_in_fields<BaseState>() == "");
  CHECK(gap_in_fields<Insertion>() == "");
  CHECK(gap_in_fields<ContactState>() == "");
  CHECK(gap_in_fields<Creep>() == "");
  CHECK(gap_in_fields<GuideState>() == "");
  CHECK(gap_in_fields<VertexState>() == "");
  CHECK(gap_in_fields<TipState>() == "");
  CHECK(gap_in_fields<ShaftCell>() == "");
  CHECK(gap_in_fields<ShaftMonitor>() == "");
  CHECK(gap_in_fields<Path>() == "");
  CHECK(gap_in_fields<TickReport>() == "");
  CHECK(gap_in_fields<NeedleReport>() == "");
  CHECK(gap_in_fields<Event>() == "");
}

}  // namespace acus::test
