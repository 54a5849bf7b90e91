// SPDX-License-Identifier: GPL-3.0-or-later
// A recording run again: the same ticks from the same states and commands, compared with what was recorded.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "server/engine/recording/recording_file.h"

namespace acus {

// The first place where a rerun and its recording go apart.
struct Difference {
  std::uint64_t epoch = 0, tick = 0;
  // What a tick tells differs at this tick. Else the state does, since the last one whose state was recorded.
  bool reported = true;
};

class Rerun {
 public:
  // Opens the recording and loads its first scene. Throws RecordingError, SceneError.
  explicit Rerun(const std::string& path, Progress progress = {});

  // Makes the next tick that was recorded; false at the end. Throws RecordingError, SceneError.
  bool step();

  const recorded::Opening& opening() const { return reader_.opening(); }
  const Simulation& simulation() const { return *simulation_; }
  const recorded::World& world() const { return world_; }  // whose simulation it is
  std::uint64_t epoch() const { return epoch_; }
  // Grows with every scene that the recording goes over to.
  int worlds() const { return worlds_; }
  std::uint64_t ticks() const { return ticks_; }  // made
  double seconds() const { return seconds_; }     // of simulation time
  const std::optional<Difference>& difference() const { return difference_; }
  // Why the recording ends, "" if somebody asked for it.
  const std::string& problem() const { return reader_.problem(); }
  bool damaged() const { return reader_.damaged(); }

 private:
  void handle(const recorded::Opening&);
  void handle(const recorded::World& world);
  void handle(const recorded::Beginning& beginning);
  void handle(const recorded::BodyCommand& given);
  void handle(const recorded::Tick& tick);
  void handle(const recorded::StateAfter& state);
  void handle(const recorded::Ending&) {}
  void differ(bool reported);
  Simulation& begun();

  RecordingReader reader_;
  const Progress progress_;
  recorded::World world_;
  std::unique_ptr<Simulation> simulation_;
  bool begun_ = false;  // a state to continue from was there
  bool ticked_ = false;
  int worlds_ = 0;
  std::uint64_t epoch_ = 0, ticks_ = 0;
  double seconds_ = 0;
  std::optional<Difference> difference_;
  Hasher hasher_;
};

}  // namespace acus
