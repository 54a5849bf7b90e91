// SPDX-License-Identifier: GPL-3.0-or-later
// What a tick tells the outside (stage 10): plain values of fixed size, no pointers into the simulation.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "server/math/types.h"
#include "server/scene/scene.h"

namespace acus {

// Where a needle's tip is.
enum class Phase : std::uint8_t {
  free,     // outside, touching nothing
  contact,  // on the surface, not through it
  inside,   // in the tissue
  through   // out again on another side, the shaft still inside
};

// Trouble that a client should know of; bits of TickReport::flags.
enum Flag : std::uint32_t {
  kLawsNotConverged = 1u << 0,   // the laws' residual is above the scene's tolerance
  kNewtonNotConverged = 1u << 1, // rungs exact, refined: the last change is above the scene's tolerance
  kTangentProjected = 1u << 2,   // an indefinite tangent was replaced by its positive part
  kRowsDropped = 1u << 3,        // more constraint points than the capacity fixed at load
  kPathFull = 1u << 4,           // a path reached its capacity and stopped recording
  kNotFinite = 1u << 5,          // a number stopped being finite; the state was held at the last good tick
  kSolverFellBack = 1u << 6,     // laws.solver direct found no answer; Gauss-Seidel gave this one
  kSweepsCapped = 1u << 7,       // overrun.max_sweeps took effect
  kIterationsCapped = 1u << 8,   // overrun.max_iterations took effect
  kPublishingReduced = 1u << 9,  // overrun.publish_every is in effect
  kStepLimited = 1u << 10,       // the tick's last step was cut, since the forces at its end spoke against it, or, not
                                 // repeated any more, still turned a needle far
  kElementsInverted = 1u << 11,  // a tetrahedron was turned inside out at the start of the tick (not with rung linear)
  kTipFoundInside = 1u << 12     // a tip stood in the tissue without a path; one was opened along its way
};

struct NeedleReport {
  std::uint64_t command_seq = 0;          // of the command in use, 0 before the first
  std::uint64_t command_tick = 0;         // tick that took it in
  Phase phase = Phase::free;
  double inserted_depth = 0;              // m of needle inside the tissue
  Pose base;                              // world, spin included
  double spin = 0;                        // rad
  Vector3 tip_position = Vector3::Zero(); // m, world
  Vector3 tip_force = Vector3::Zero();    // N, world, by the tissue on the tip (cutting or contact and lateral)
  Vector3 base_force = Vector3::Zero();   // N, world, by the needle on its holder: what a hand feels
  Vector3 base_torque = Vector3::Zero();  // N m, world, about the base, by the needle on its holder
  // Forces of the tissue on the needle by law; their sum is all the tissue does to it. N, world.
  Vector3 cutting_force = Vector3::Zero();   // on the tip along its way: contact with a surface or border, cutting
  Vector3 friction_force = Vector3::Zero();  // along the path, whole shaft
  Vector3 lateral_force = Vector3::Zero();   // across the path, shaft and tip
  Vector3 guide_force = Vector3::Zero();     // of the guides on the needle, N, world
};

enum class EventKind : std::uint8_t { contact, release, puncture, crossing, reentry, exit, withdrawal, intrusion };

struct Event {
  std::uint64_t tick = 0;
  int needle = 0;
  EventKind kind = EventKind::contact;
  int region = 0;                      // that the tip touches or goes into; exit, withdrawal: that it leaves
  Vector3 position = Vector3::Zero();  // m, world
  double force = 0;                    // N, of the law that caused it
};

inline constexpr int kStageCount = 10;
inline constexpr std::array<const char*, kStageCount> kStageNames{
    "commands", "needle_free", "tissue_free", "locate", "rows", "compliance", "solve", "correct", "transitions", "report"};

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
  std::array<double, kStageCount> stage_seconds{};  // only if timing is switched on
  std::vector<NeedleReport> needles;                // one per needle of the scene
  std::vector<Event> events;                        // of this tick; capacity reserved at load
};

}  // namespace acus
