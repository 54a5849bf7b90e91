// SPDX-License-Identifier: MIT
// A run's shapes in one file: what a picture or a film needs to draw it. The messages themselves, one after the other:
// hello_reply, describe_reply, then needle and tissue states, and poses of guides; protocol/README.md, "Recorded
// shapes". Written as they come; nothing is kept in memory.
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <string_view>

#include "client/replay/log_file.h"
#include "protocol/messages.h"

namespace acus::client {

// Whether a file that begins so holds recorded shapes or messages: the first is the server's answer to a hello.
bool are_messages(std::string_view beginning);

class ShapeLog {
 public:
  // Throws LogError if the file cannot be written.
  explicit ShapeLog(const std::string& path);

  // What is simulated; comes first, and tells how many ticks lie between two shapes. Throws ProtocolMismatch if hello
  // does not tell it.
  void begin(const protocol::HelloReply& hello, const protocol::DescribeReply& describe);

  void write(const protocol::NeedleShape& shape);
  void write(const protocol::TissueShape& shape);
  void write(const protocol::Pose& guide);

  // Whether all shapes are here that the server makes after this tick.
  bool complete_at(std::uint64_t tick) const;

  std::uint64_t shapes() const { return shapes_; }  // received
  std::uint64_t lost() const;                       // that never came between those received

  // Everything is on its way to the disk after this. Throws LogError if anything could not be written.
  void close();

  bool begun() const { return file_.begun(); }  // whether there was anything to write
  const std::string& path() const { return file_.path(); }

 private:
  // The shapes of one needle or of the tissue, which come at every multiple of `period` ticks.
  struct Series {
    std::uint64_t period = 1;
    std::uint64_t last_tick = 0;  // received; 0 before the first
    std::uint64_t lost = 0;

    void take(std::uint64_t tick);
  };

  template <class Message>
  void append(const Message& message);

  LogFile file_;
  std::string bytes_;  // of the message being written
  std::map<std::string, Series> needles_;
  Series tissue_;
  std::uint64_t shapes_ = 0;
};

}  // namespace acus::client
