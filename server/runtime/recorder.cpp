// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/recorder.h"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <system_error>

#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "server/runtime/privileges.h"

namespace acus {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxItems = 32768;  // in the queue, about 5 MB: 16 s of one needle at 1 kHz
constexpr auto kPoll = std::chrono::milliseconds(20);
constexpr auto kFlush = std::chrono::milliseconds(500);
constexpr std::size_t kMaxPending = 8 << 20;  // bytes of a frame before it is packed, but for what one item has more

}  // namespace

Recorder::Recorder(const std::string& path, const std::string& server)
    : path_(path), queue_(kMaxItems), writer_(path), flushed_(Clock::now()) {
  try {
    writer_.add(opening_now(server));
    writer_.flush();
    thread_ = std::thread([this] { run(); });
  } catch (const std::exception& error) {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);  // which was made for this, and holds nothing
    throw RecordingError(path + ": the recording cannot begin: " + error.what());
  }
}

bool Recorder::finish() {
  stop_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
  return whole_;
}

void Recorder::run() {
  lower_priority();
  for (bool last = false; !last;) {
    try {
      last = turn();
    } catch (const std::exception& error) {  // no memory: the item that it met is the last one looked at
      fail(error.what());
    }
    if (!last) std::this_thread::sleep_for(kPoll);
  }
}

// Whether nothing comes any more.
bool Recorder::turn() {
  const bool last = stop_.load(std::memory_order_acquire);
  const bool full = gave_up_.load(std::memory_order_acquire);
  take_items();
  if (full) end("the disk did not keep up with the simulation");
  if (last) end("");
  if (Clock::now() - flushed_ > kFlush) flush();
  return last;
}

void Recorder::take_items() {
  while (RecorderItem* item = queue_.readable()) {
    if (auto* begun = std::get_if<EpochBegun>(item)) box_ = std::move(begun->state);  // the other thread looks into it
    if (recording()) write(*item);
    *item = SecondOver{};  // what it held is freed here
    queue_.release();
    if (writer_.pending() > kMaxPending) flush();
  }
}

void Recorder::write(RecorderItem& item) {
  if (const auto* tick = std::get_if<recorded::Tick>(&item)) {
    writer_.add(*tick);
    last_tick_ = tick->tick;
  } else if (const auto* given = std::get_if<recorded::BodyCommand>(&item)) {
    writer_.add(*given);
  } else if (auto* begun = std::get_if<EpochBegun>(&item)) {
    if (begun->world != world_) writer_.add(*begun->world);
    world_ = std::move(begun->world);
    writer_.add(recorded::Beginning{begun->epoch, make_snapshot(world_->fingerprint, box_->state)});
    box_->full.store(false, std::memory_order_release);
  } else {
    writer_.add(recorded::StateAfter{box_->state.tick, comparable_hash(box_->state)});
    box_->full.store(false, std::memory_order_release);
  }
}

void Recorder::flush() {
  if (!recording()) return;
  flushed_ = Clock::now();
  try {
    writer_.flush();
  } catch (const RecordingError& error) {
    fail(error.what());
  }
}

void Recorder::fail(const char* why) {
  recording_.store(false, std::memory_order_relaxed);
  spdlog::error("{}: {}; the recording ends before that, and the simulation goes on", path_, why);
}

void Recorder::end(const std::string& why) {
  if (!recording()) return;
  writer_.add(recorded::Ending{why});
  flush();
  if (!recording()) return;
  recording_.store(false, std::memory_order_relaxed);
  whole_ = why.empty();
  if (whole_) {
    spdlog::info("recorded into {}, {} bytes, up to tick {}", path_, writer_.bytes(), last_tick_);
  } else {
    spdlog::error("{}: {}; the recording ends at tick {}, and the simulation goes on", path_, why, last_tick_);
  }
}

}  // namespace acus
