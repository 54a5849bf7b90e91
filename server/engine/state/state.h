// SPDX-License-Identifier: GPL-3.0-or-later
// Everything that the next tick depends on, besides the model and the commands that come in: a value. Copies are
// independent and have the same room. What a struct holds is listed in its fields(); state_bytes.h makes a hash,
// equality and a byte image of it.
//
// Within a tick only the last stages of a good one write it (stages/commit.cpp, stages/transitions.cpp); between ticks
// Simulation::economize(), reset() and restore() do.
#pragma once

#include <cstdint>
#include <vector>

#include "server/engine/models/needle/needle.h"
#include "server/engine/models/tissue/tissue.h"
#include "server/engine/state/needle/base_state.h"
#include "server/engine/state/needle/guide_state.h"
#include "server/engine/state/needle/insertion_state.h"
#include "server/engine/state/needle/path.h"

namespace acus {

struct Model;

// The needles' part of the balance of forces, which the next tick completes with the tissue's.
struct NeedleBalance {
  Vector3 sum = Vector3::Zero();  // base forces + guides' forces + weight - inertia of all needles (N)
  double largest_force = 0;       // N
  double contact_forces = 0;      // N, of one needle, their amounts added up: at a reversal they oppose each other

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("sum", self.sum);
    visit("largest_force", self.largest_force);
    visit("contact_forces", self.contact_forces);
  }
};

struct State {
  std::uint64_t tick = 0;              // good ticks since loading or the last reset
  bool economizing = false;            // iterations are reduced as the scene's `overrun` allows
  TissueState tissue;
  std::vector<NeedleState> needles;
  std::vector<BaseState> bases;        // per needle
  std::vector<Insertion> insertions;   // per needle
  std::vector<ShaftMonitor> monitors;  // per needle
  std::vector<GuideState> guides;
  std::vector<Path> paths;             // kMaxPaths, most of them empty
  NeedleBalance balance;
  double surface_moved = 0;  // m, the largest way of a surface's node in each tick, added up
  double spring_energy = 0;  // J, of the rows with a compliance, see Rows::elastic_energy()

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("tick", self.tick);
    visit("economizing", self.economizing);
    visit("tissue", self.tissue);
    visit("needles", self.needles);
    visit("bases", self.bases);
    visit("insertions", self.insertions);
    visit("monitors", self.monitors);
    visit("guides", self.guides);
    visit("paths", self.paths);
    visit("balance", self.balance);
    visit("surface_moved", self.surface_moved);
    visit("spring_energy", self.spring_energy);
  }
};

// Undeformed, at rest.
State make_state(const Model& model);

}  // namespace acus
