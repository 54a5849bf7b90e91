// SPDX-License-Identifier: GPL-3.0-or-later
// The recording that is under way, if one is, and where clients may begin one.
#pragma once

#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "protocol/enums.h"
#include "server/runtime/recorder.h"

namespace acus {

class Recordings {
 public:
  // Clients' recordings go into `folder`; empty: they may not begin any. `server` is its version.
  Recordings(std::string folder, std::string server) : folder_(std::move(folder)), server_(std::move(server)) {}

  // Throw RecordingError while one is under way, and if there can be none.
  void begin(const std::string& path);
  void begin_for_client(const std::string& name);  // a file's plain name

  // Throws RecordingError if none is under way, or it was asked for already.
  void ask_to_end();
  // Once the simulation thread does not use the recorder any more: what is left goes to the file on a thread of its
  // own.
  void end();
  bool is_ending() const { return ending_.valid(); }

  struct Ended {
    std::string name;
    bool whole;  // nothing is missing
  };
  // Once after each end(), when the file is closed.
  std::optional<Ended> take_ended();

  // At the end of the program, when nothing takes ticks any more: brings what is left to the file. Whether nothing is
  // missing there.
  bool finish();

  Recorder* recorder() const { return is_ending() ? nullptr : recorder_.get(); }  // that takes ticks; null: none does
  std::string name() const;  // of the file that is being written, without the folder; empty: none is
  protocol::RecordingState state() const;

 private:
  const std::string folder_, server_;
  std::shared_ptr<Recorder> recorder_;
  bool asked_to_end_ = false;
  std::future<bool> ending_;
};

}  // namespace acus
