// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/export/messages_export.h"

#include <algorithm>

#include "server/runtime/convert.h"

namespace acus {

namespace {

// With the rate of shapes in the file, which is not that of the scene.
protocol::HelloReply hello_with_rate(const Rerun& rerun, double rate) {
  protocol::HelloReply hello = hello_of(rerun);
  for (protocol::TopicInfo& topic : hello.topics)
    if (topic.name == protocol::NeedleShape::kType || topic.name == protocol::TissueShape::kType)
      topic.rate = std::min(rate, hello.rate);
  return hello;
}

}  // namespace

MessagesExport::MessagesExport(const std::string& path, double rate, const Rerun& rerun)
    : file_(path),
      clock_(rate),
      world_(rerun.worlds()),
      shapes_(rerun),
      forces_(static_cast<std::size_t>(needle_count(rerun))) {
  file_.write(hello_with_rate(rerun, rate));
  file_.write(describe_of(rerun));
  file_.flush();
}

void MessagesExport::take(const Rerun& rerun) {
  if (rerun.worlds() == world_) {
    keep_forces(rerun);
    keep_events(rerun);
    if (clock_.due(rerun)) write_frame(rerun);
  } else {
    write_kept();
  }
  file_.flush_if_due();
}

void MessagesExport::close(const Rerun& rerun) {
  const bool ticked = std::ranges::any_of(forces_, [](const Forces& forces) { return forces.last.has_value(); });
  if (ticked && rerun.worlds() == world_) {
    write_frame(rerun);
  } else {
    write_kept();
  }
  file_.close();
}

void MessagesExport::keep_forces(const Rerun& rerun) {
  for (int i = 0; i < needle_count(rerun); ++i) {
    Forces& forces = forces_[static_cast<std::size_t>(i)];
    Kept state{rerun.ticks(), 0, force_of(rerun, i)};
    state.force = from_wire(state.message.base_force).norm();
    if (!forces.smallest || state.force < forces.smallest->force) forces.smallest = state;
    if (!forces.largest || state.force > forces.largest->force) forces.largest = state;
    forces.last = std::move(state);
  }
}

// Events of a tick follow its forces, as from the server.
void MessagesExport::keep_events(const Rerun& rerun) {
  const TickReport& report = rerun.simulation().report();
  std::size_t place = forces_.size();
  for (const Event& event : report.events)
    kept_[{rerun.ticks(), place++}] =
        protocol::encode(to_wire(event, rerun.epoch(), report.time, rerun.simulation().scene()));
}

void MessagesExport::write_frame(const Rerun& rerun) {
  write_kept();
  for (int i = 0; i < needle_count(rerun); ++i) file_.write(shapes_.needle(rerun, i));
  file_.write(shapes_.tissue(rerun));
}

// In the order of ticks. A state that is two of the three has one place, and is written once.
void MessagesExport::write_kept() {
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    for (const std::optional<Kept>* state : {&forces_[i].smallest, &forces_[i].largest, &forces_[i].last})
      if (*state) kept_[{(*state)->tick, i}] = protocol::encode((*state)->message);
    forces_[i] = {};
  }
  for (const auto& [place, message] : kept_) file_.append(message);
  kept_.clear();
}

}  // namespace acus
