// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/recording/state_recorder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"

namespace acus {

StateRecorder::StateRecorder(const std::string& path, const std::string& version,
                             std::shared_ptr<const recorded::World> world, const State& state)
    : writer_(path),
      world_(std::move(world)),
      half_second_(std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(world_->rate / 2)))) {
  writer_.add(opening_now(version));
  writer_.add(*world_);
  writer_.add(recorded::Beginning{0, make_snapshot(world_->fingerprint, state)});
  writer_.flush();
}

void StateRecorder::tick(bool economizing, const TickReport& report, const State& after) {
  writer_.add(recorded::Tick{report.tick, digest(hasher_, report), economizing});
  if (report.tick % (2 * half_second_) == 0) writer_.add(recorded::StateAfter{after.tick, comparable_hash(after)});
  if (report.tick % half_second_ == 0) flush();
}

void StateRecorder::end() {
  if (ended_) return;
  writer_.add(recorded::Ending{});
  flush();
  ended_ = true;
}

StateRecorder::~StateRecorder() {
  try {
    end();
  } catch (const RecordingError&) {  // its reader finds that it ends too early
  }
}

// What comes after a gap is never written.
void StateRecorder::flush() {
  if (ended_) return;
  try {
    writer_.flush();
  } catch (...) {
    ended_ = true;
    throw;
  }
}

}  // namespace acus
