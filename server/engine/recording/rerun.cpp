// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/recording/rerun.h"

#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"

namespace acus {

Rerun::Rerun(const std::string& path, Progress progress) : reader_(path), progress_(std::move(progress)) {
  while (!begun_) {
    const std::optional<recorded::Item> item = reader_.next();
    if (!item) throw RecordingError(path + ": the recording ends before its first tick: " + reader_.problem());
    std::visit([this](const auto& it) { handle(it); }, *item);
  }
}

bool Rerun::step() {
  ticked_ = false;
  while (!ticked_) {
    const std::optional<recorded::Item> item = reader_.next();
    if (!item) return false;
    std::visit([this](const auto& it) { handle(it); }, *item);
  }
  return true;
}

void Rerun::handle(const recorded::Opening&) { throw RecordingError("the recording begins twice"); }

void Rerun::handle(const recorded::World& world) {
  begun_ = false;
  world_ = world;
  simulation_ = simulation_of(world_, progress_);
  ++worlds_;
}

void Rerun::handle(const recorded::Beginning& beginning) {
  if (!simulation_) throw RecordingError("the recording has a state before a scene");
  try {
    simulation_->restore(read_snapshot(simulation_->model(), beginning.snapshot));
  } catch (const SnapshotError& error) {
    throw RecordingError(std::string("a state of the recording cannot be used: ") + error.what());
  }
  epoch_ = beginning.epoch;
  begun_ = true;
}

Simulation& Rerun::begun() {
  if (!begun_) throw RecordingError("the recording has ticks before a state to begin with");
  return *simulation_;
}

void Rerun::handle(const recorded::BodyCommand& given) {
  Simulation& simulation = begun();
  const Scene& scene = simulation.scene();
  if (static_cast<std::size_t>(given.body) >= scene.needles.size() + scene.guides.size())
    throw RecordingError("the recording commands a needle or guide that its scene does not have");
  if (!simulation.command(given.body, given.command))
    throw RecordingError("the recording has a command that is out of range");
}

void Rerun::handle(const recorded::Tick& tick) {
  Simulation& simulation = begun();
  simulation.economize(tick.economizing);
  simulation.step();
  ticked_ = true;
  ++ticks_;
  seconds_ += simulation.model().h;
  if (simulation.report().tick != tick.tick || digest(hasher_, simulation.report()) != tick.digest) differ(true);
}

void Rerun::handle(const recorded::StateAfter& recorded) {
  State state = begun().state();
  if (comparable_hash(state) != recorded.hash || state.tick != recorded.tick) differ(false);
}

void Rerun::differ(bool reported) {
  if (!difference_) difference_ = {epoch_, simulation_->report().tick, reported};
}

}  // namespace acus
