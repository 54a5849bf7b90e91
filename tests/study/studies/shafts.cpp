// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/shafts.h"

#include <algorithm>
#include <cmath>

#include "server/engine/math/processor_time.h"
#include "server/engine/math/random.h"
#include "server/engine/tick/simulation.h"

namespace acus {

namespace {

constexpr double kThinnest = 0.5e-3, kThickest = 1.5e-3;  // m
constexpr double kSwept = 30e-3, kSweep = 40e-3;          // m
constexpr double kRest = 0.3;                             // s, at the end

class ShaftRun {
 public:
  explicit ShaftRun(const Shaft& shaft) : shaft_(shaft), simulation_(shaft.entry.scene) {}

  // Whether there is more to come.
  bool step() {
    const double h = 1 / shaft_.entry.scene.rate;
    way_ = std::min(way_ + shaft_.entry.speed * h, shaft_.push + shaft_.sweep);
    const Pose& start = shaft_.entry.scene.needles[0].base;
    const Vector3 gone =
        std::min(way_, shaft_.push) * shaft_.entry.along + std::max(0.0, way_ - shaft_.push) * shaft_.aside;
    simulation_.command(0, {.pose = Pose{start.position + gone, start.orientation}, .spin = {}});
    outcome_.seconds += processor_time_of([&] { simulation_.step(); });
    note(simulation_.report());
    if (way_ == shaft_.push + shaft_.sweep) rested_ += h;
    return rested_ < kRest;
  }

  const ShaftOutcome& outcome() const { return outcome_; }

 private:
  void note(const TickReport& report) {
    const NeedleReport& needle = report.needles[0];
    ++outcome_.ticks;
    outcome_.flags |= report.flags;
    outcome_.inverted_ticks += (report.flags & kElementsInverted) != 0;
    outcome_.unheld = std::max(outcome_.unheld, needle.unheld);
    outcome_.unheld_at_end = needle.unheld;
    outcome_.largest_force = std::max(outcome_.largest_force, needle.base_force.norm());
    const auto& cells = simulation_.state().insertions[0].cells;
    outcome_.borne_ticks += std::ranges::any_of(cells, [](const ShaftCell& cell) { return cell.contact.along > 0; });
  }

  const Shaft& shaft_;
  Simulation simulation_;
  double way_ = 0;     // m
  double rested_ = 0;  // s
  ShaftOutcome outcome_;
};

}  // namespace

Shaft random_shaft(int number, const std::vector<GmshMesh>& meshes) {
  Shaft shaft{.entry = random_entry(number, meshes)};
  Random random(static_cast<unsigned>(number) + 1'000'000);
  Needle& needle = shaft.entry.scene.needles[0];
  needle.outer_diameter = random.uniform(kThinnest, kThickest);
  const Vector3 aside = shaft.entry.along.cross(random.direction());
  shaft.aside = aside.normalized();
  if (number % 2 == 1) {
    shaft.push = kSwept;
    shaft.sweep = kSweep;
  }
  return shaft;
}

ShaftOutcome run_shaft(const Shaft& shaft) {
  ShaftRun run(shaft);
  while (run.step()) {
  }
  return run.outcome();
}

}  // namespace acus
