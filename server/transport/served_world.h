// SPDX-License-Identifier: GPL-3.0-or-later
// The world that clients see and the one that they command. They are the same but from when a loaded world is on its
// way to the simulation thread until its first states come. Epochs count likewise.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "server/runtime/request.h"

namespace acus {

class ServedWorld {
 public:
  explicit ServedWorld(LoadedScene& world) : published_(&world), commanded_(&world) {}

  LoadedScene& published() const { return *published_; }
  std::uint64_t published_epoch() const { return published_epoch_; }
  const LoadedScene& commanded() const { return *commanded_; }
  std::uint64_t commanded_epoch() const { return commanded_epoch_; }
  bool settled() const { return published_ == commanded_; }

  // What is commanded from now on belongs to another epoch, and perhaps to another world. `recording`: with a box for
  // the recorder. Throws std::bad_alloc, and all is as before.
  NewEpoch begin_epoch(bool recording) { return begin_epoch(*commanded_, recording); }
  NewEpoch begin_epoch(const LoadedScene& world, bool recording) {
    std::unique_ptr<StateBox> box = recording ? make_box(world) : nullptr;
    commanded_ = &world;
    return {++commanded_epoch_, std::move(box)};
  }
  // The simulation thread has come to it.
  void publish(LoadedScene& world, std::uint64_t epoch) {
    published_ = &world;
    published_epoch_ = epoch;
  }

  // For the simulation thread to copy the commanded world's state into.
  std::unique_ptr<State> make_room() const {
    return std::make_unique<State>(make_state(commanded_->simulation.model()));
  }
  std::unique_ptr<StateBox> make_box() const { return make_box(*commanded_); }

 private:
  static std::unique_ptr<StateBox> make_box(const LoadedScene& world) {
    auto box = std::make_unique<StateBox>();
    box->state = make_state(world.simulation.model());
    return box;
  }

  LoadedScene* published_;
  const LoadedScene* commanded_;
  std::uint64_t published_epoch_ = 0, commanded_epoch_ = 0;
};

}  // namespace acus
