// SPDX-License-Identifier: GPL-3.0-or-later
// Writes down what the simulation thread is told and what comes of it, on a thread of its own.
//
// The simulation thread puts items of fixed size into a queue and copies its state into a box that another thread made;
// it never waits. Every half second what came in goes to the file: a process that is killed loses no more than that.
// When the file cannot be written on, or the queue is full because the disk stands still, the recording ends there and
// the simulation continues.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <variant>

#include "server/engine/recording/recording_file.h"
#include "server/runtime/exchange.h"
#include "server/runtime/loaded_scene.h"

namespace acus {

// Items for the recorder, from the simulation thread.
struct EpochBegun {
  std::uint64_t epoch = 0;
  std::shared_ptr<const recorded::World> world;
  std::unique_ptr<StateBox> state;  // full; serves for the seconds that follow, too
};
struct SecondOver {};  // the state of the tick before lies in the newest box
using RecorderItem = std::variant<SecondOver, EpochBegun, recorded::BodyCommand, recorded::Tick>;

class Recorder {
 public:
  // Creates the file, which must not be there, and starts the thread. Throws RecordingError.
  Recorder(const std::string& path, const std::string& server);
  ~Recorder() { finish(); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  const std::string& path() const { return path_; }

  SpscQueue<RecorderItem>& queue() { return queue_; }  // the simulation thread writes
  // The queue was full in real time: what comes is without what was lost.
  void give_up() { gave_up_.store(true, std::memory_order_release); }

  // Whether it continues; if not, the file ends before what comes.
  bool recording() const { return recording_.load(std::memory_order_relaxed); }

  // Writes what is in the queue and ends the file; whether all of it was written. The simulation thread must not use it
  // any more.
  bool finish();

 private:
  void run();
  bool turn();
  void take_items();
  void write(RecorderItem& item);
  void flush();
  void fail(const char* why);
  void end(const std::string& why);

  const std::string path_;
  SpscQueue<RecorderItem> queue_;
  std::atomic<bool> gave_up_{false}, stop_{false}, recording_{true};

  // Of its thread.
  RecordingWriter writer_;
  std::shared_ptr<const recorded::World> world_;  // that was written last
  std::unique_ptr<StateBox> box_;
  std::uint64_t last_tick_ = 0;
  bool whole_ = false;  // the file holds all, and has ended
  std::chrono::steady_clock::time_point flushed_;
  std::thread thread_;
};

}  // namespace acus
