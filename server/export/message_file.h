// SPDX-License-Identifier: GPL-3.0-or-later
// Messages of the protocol in a file, one after the other, which others read while it grows: whole messages get there
// together, and none waits for long.
#pragma once

#include <chrono>
#include <string>

#include "client/replay/log_file.h"
#include "client/replay/shape_log.h"
#include "protocol/codec.h"

namespace acus {

class MessageFile {
 public:
  // Throws client::LogError, here and below.
  explicit MessageFile(const std::string& path) : file_(path, client::are_messages) {}

  template <class Message>
  void write(const Message& message) {
    protocol::encode(message, bytes_);
    append(bytes_);
  }
  void append(const std::string& message) { pending_ += message; }

  // All that was written is in the file after this.
  void flush() {
    flushed_ = Clock::now();
    std::ofstream& out = file_.out();
    out.write(pending_.data(), static_cast<std::streamsize>(pending_.size()));
    out.flush();
    pending_.clear();
    if (!out) file_.close();  // which throws
  }
  // To be called after each tick.
  void flush_if_due() {
    if (pending_.size() > kMaxPending || Clock::now() - flushed_ > kFlush) flush();
  }
  void close() {
    flush();
    file_.close();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr auto kFlush = std::chrono::milliseconds(100);
  static constexpr std::size_t kMaxPending = std::size_t{1} << 20;  // bytes

  client::LogFile file_;
  std::string bytes_;    // of the message being written
  std::string pending_;  // whole messages
  Clock::time_point flushed_ = Clock::now();
};

}  // namespace acus
