// SPDX-License-Identifier: GPL-3.0-or-later
// A small block of tissue, needles around it, and commands that move them: the bench on which single laws are tested.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "server/engine/models/geometry/surface.h"
#include "server/engine/tick/simulation.h"
#include "tests/support/drawn_gap.h"

namespace acus::test {

// A steel needle of 0.1 m whose tip is `above` (m) the point `at` of a face, pointing down (or up).
Needle needle_at(const Vector3& at, double above, bool down = true);

// A block of `height` (m) on 60 mm x 60 mm around the origin in 6 x 6 x 6 cells, held at its four sides, of one
// material without viscosity; one needle 5 mm above it, off its axis.
Scene block_scene(double height = 0.06);

// Runs a simulation; needles and guides keep the last pose they were moved to. Bodies are numbered as in
// Simulation::command().
class Bench {
 public:
  explicit Bench(const Scene& scene);

  // Moves a body by a vector (m, world) at a speed (m/s), or spins it to an angle (rad) at a rate (rad/s).
  void move(int body, const Vector3& by, double speed);
  void push(int needle, double by, double speed);  // along its axis
  void turn(int body, const Vector3& by, double rate);  // about the base (rad, world; rad/s)
  void spin(int needle, double to, double rate);
  void screw(int needle, double by, double speed, double rate);  // both at once: m along its axis, rad/s
  void wait(double seconds);

  const Simulation& simulation() const { return simulation_; }
  const NeedleReport& needle(int i = 0) const { return simulation_.report().needles[static_cast<std::size_t>(i)]; }
  Vector3 axis(int needle = 0) const;       // the base's +x
  double resistance(int needle = 0) const;  // N, against insertion, at the base
  double twist(int needle = 0) const;       // rad, of the tip against the base about the axis
  double tissue_displacement() const;       // m, largest coordinate
  std::vector<Event> events(EventKind kind, int needle = 0) const;
  std::uint32_t flags() const { return flags_; }  // of all ticks so far
  bool finite() const { return finite_; }         // so were all reports

  std::function<void()> each_tick;  // called after every tick, may be empty
  bool may_intrude = false;         // a tip may be found inside: the test throws it there

 private:
  void tick();

  // What holds in every tick of every test.
  void check_invariants();

  Simulation simulation_;
  Surface surface_;
  DrawnGap drawn_;
  std::vector<Command> commands_;
  std::vector<Event> events_;
  std::vector<Phase> phases_;  // per needle, after the last tick
  std::uint32_t flags_ = 0;
  bool finite_ = true;
};

}  // namespace acus::test
