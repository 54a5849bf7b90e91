// SPDX-License-Identifier: GPL-3.0-or-later
// A recording that a test writes by hand.
#pragma once

#include <doctest/doctest.h>

#include <optional>
#include <string>

#include "server/engine/recording/recording_file.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "tests/support/small_block.h"

namespace acus::test {

// Goes in at 0.1 m/s and writes down what it does.
class RecordedRun {
 public:
  explicit RecordedRun(const std::string& path) : writer_(path) {
    writer_.add(recorded::Opening{1, "0.1", ""});
    load(small_block());
    begin(0);
  }

  void load(const Scene& scene) {
    simulation_.emplace(scene);
    writer_.add(record_of(scene, simulation_->mesh(), simulation_->model().fingerprint));
  }

  void begin(std::uint64_t epoch) {
    writer_.add(recorded::Beginning{epoch, make_snapshot(simulation_->model().fingerprint, simulation_->state())});
  }

  void tick(bool economizing = false) {
    const recorded::BodyCommand told{0, next_command()};
    REQUIRE(simulation_->command(0, told.command));
    writer_.add(told);
    simulation_->economize(economizing);
    simulation_->step();
    writer_.add(
        recorded::Tick{simulation_->report().tick, digest(hasher_, simulation_->report()) ^ wrong_, economizing});
  }

  // What the next tick is told.
  Command next_command() {
    Pose pose = simulation_->scene().needles[0].base;
    pose.position.z() -= 2e-4 * static_cast<double>(++seq_);
    return {.seq = seq_, .pose = pose, .spin = {}};
  }

  void state() {
    State copy = simulation_->state();
    writer_.add(recorded::StateAfter{copy.tick, comparable_hash(copy) ^ wrong_});
  }

  void go_wrong() { wrong_ = 1; }
  void go_right() { wrong_ = 0; }
  Simulation& simulation() { return *simulation_; }
  RecordingWriter& writer() { return writer_; }

 private:
  RecordingWriter writer_;
  std::optional<Simulation> simulation_;
  Hasher hasher_;
  std::uint64_t seq_ = 0, wrong_ = 0;
};

}  // namespace acus::test
