// SPDX-License-Identifier: GPL-3.0-or-later
// What a tick tells the outside (stage 10): plain values of fixed size, no pointers into the simulation. What a struct
// holds is listed in its fields(), of which report_hash.h makes a hash.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "server/engine/math/types.h"
#include "server/engine/scene/scene.h"
#include "server/engine/state/needle/enums.h"

namespace acus {

struct NeedleReport {
  std::uint64_t command_seq = 0;          // of the command in use, 0 before the first
  std::uint64_t command_tick = 0;         // tick that took it in
  Phase phase = Phase::free;
  double inserted_depth = 0;              // m of needle inside the tissue
  double unheld = 0;                      // m of needle in tissue beside its path that no contact bears
  Pose base;                              // world, spin included
  Pose commanded;                         // where commands have it, likewise: the base itself unless a spring holds it
  double spin = 0;                        // rad
  Vector3 tip_position = Vector3::Zero(); // m, world
  Vector3 tip_force = Vector3::Zero();    // N, world, by the tissue on the tip (cutting or contact and lateral)
  Vector3 base_force = Vector3::Zero();   // N, world, by the needle on its holder: what a hand feels
  Vector3 base_torque = Vector3::Zero();  // N m, world, about the base, by the needle on its holder
  // Forces of the tissue on the needle by law; their sum is all the tissue does to it. N, world.
  Vector3 cutting_force = Vector3::Zero();   // on the tip along its way: contact, friction of contact, cutting
  Vector3 friction_force = Vector3::Zero();  // along the path, whole shaft
  Vector3 lateral_force = Vector3::Zero();   // across the path, shaft and tip
  Vector3 guide_force = Vector3::Zero();     // of the guides on the needle, N, world
  Vector3 needle_force = Vector3::Zero();    // of other needles on it, N, world

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("command_seq", self.command_seq);
    visit("command_tick", self.command_tick);
    visit("phase", self.phase);
    visit("inserted_depth", self.inserted_depth);
    visit("unheld", self.unheld);
    visit("spin", self.spin);
    visit("base", self.base);
    visit("commanded", self.commanded);
    visit("tip_position", self.tip_position);
    visit("tip_force", self.tip_force);
    visit("base_force", self.base_force);
    visit("base_torque", self.base_torque);
    visit("cutting_force", self.cutting_force);
    visit("friction_force", self.friction_force);
    visit("lateral_force", self.lateral_force);
    visit("guide_force", self.guide_force);
    visit("needle_force", self.needle_force);
  }
};

struct Event {
  std::uint64_t tick = 0;
  int needle = 0;
  EventKind kind = EventKind::contact;
  int region = 0;                      // that the tip touches or goes into; exit, withdrawal: that it leaves
  Vector3 position = Vector3::Zero();  // m, world
  double force = 0;                    // N, of the law that caused it

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("tick", self.tick);
    visit("needle", self.needle);
    visit("kind", self.kind);
    visit("region", self.region);
    visit("position", self.position);
    visit("force", self.force);
  }
};

// The stages of a tick, in their order.
enum class Stage : std::uint8_t {
  take_commands,
  needle_free_motion,
  tissue_free_motion,
  locate,
  build_rows,
  compute_compliance,
  solve_laws,
  correct,
  transitions,
  report
};
inline constexpr std::array<const char*, 10> kStageNames{
    "take_commands",      "needle_free_motion", "tissue_free_motion", "locate",      "build_rows",
    "compute_compliance", "solve_laws",         "correct",            "transitions", "report"};
inline constexpr std::size_t kStageCount = kStageNames.size();

struct TickReport {
  std::uint64_t tick = 0;     // ticks since the start or the last reset
  double time = 0;            // s, tick * h
  std::uint32_t flags = 0;
  int rows = 0;               // scalar rows of the laws
  LawMethod solver = LawMethod::gauss_seidel;  // which one answered, last Newton iteration
  int sweeps = 0;             // of Gauss-Seidel, likewise
  int newton_iterations = 0;
  double residual = 0;        // N, largest violation of a law
  double imbalance = 0;       // N, sum of all forces on needle and tissue incl. inertia; zero in exact arithmetic
  double largest_force = 0;   // N, the largest force in that sum
  std::vector<NeedleReport> needles;                // one per needle of the scene
  std::vector<Event> events;                        // of this tick; capacity reserved at load

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("tick", self.tick);
    visit("time", self.time);
    visit("flags", self.flags);
    visit("rows", self.rows);
    visit("solver", self.solver);
    visit("sweeps", self.sweeps);
    visit("newton_iterations", self.newton_iterations);
    visit("residual", self.residual);
    visit("imbalance", self.imbalance);
    visit("largest_force", self.largest_force);
    visit("needles", self.needles);
    visit("events", self.events);
  }
};

}  // namespace acus
