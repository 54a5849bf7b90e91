// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/needle/phase.h"

#include <algorithm>
#include <cassert>

namespace acus {

void change_phase(Insertion& insertion, Phase to) {
  assert(to == insertion.phase || std::ranges::any_of(kPhaseChanges, [&](const PhaseChange& change) {
    return change.from == insertion.phase && change.to == to;
  }));
  insertion.phase = to;
}

void enter(Insertion& insertion, int path, double needle_length) {
  assert(path >= 0 && insertion.path < 0);
  change_phase(insertion, Phase::inside);
  insertion.path = path;
  insertion.tip = TipState{};
  insertion.touched = MaterialPoint{};
  insertion.slipping = false;
  std::fill(insertion.vertices.begin(), insertion.vertices.end(), VertexState{.s = needle_length});
  insertion.end_s = needle_length;
}

void forget(Insertion& insertion) {
  change_phase(insertion, Phase::free);
  std::vector<VertexState> vertices = std::move(insertion.vertices);
  vertices.assign(vertices.size(), VertexState{});
  std::vector<ShaftCell> cells = std::move(insertion.cells);
  insertion = Insertion{};
  insertion.vertices = std::move(vertices);
  insertion.cells = std::move(cells);
}

}  // namespace acus
