// SPDX-License-Identifier: MIT
// The messages of a run in a file that still grows, as acus-export --messages writes it (protocol/README.md, "Recorded
// messages"), by frames: the forces and events since the frame before, then the shapes.
#pragma once

#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "client/view/outbox.h"

namespace acus::view {

class MessageIndex {
 public:
  explicit MessageIndex(std::string file) : path_(std::move(file)) {}

  // Takes in what has come since; no more than some megabytes at a time. False if nothing has.
  bool read_on();

  const std::string& hello() const { return hello_; }  // empty: it has not come yet
  const std::string& describe() const { return describe_; }

  // Whole ones: one that still grows does not count before the next has begun.
  std::size_t frames() const { return begins_.empty() ? 0 : begins_.size() - 1; }
  // The last frame is whole, too.
  void close();

  // The messages of a frame, in order.
  void visit(std::size_t frame, const std::function<void(const Frame&)>& take);
  // Those of the events up to a frame, and of the last force of each needle in one of every `stride` frames from
  // `from`.
  void visit_history(std::size_t from, std::size_t frame, std::size_t stride,
                     const std::function<void(const Frame&)>& take);

 private:
  struct Entry {
    std::uint64_t offset;
    std::uint32_t size;
    bool event, force;
  };

  void add(std::string_view message, std::uint64_t offset);
  std::string load(const Entry& entry);

  const std::string path_;
  std::ifstream file_;
  std::string unread_;        // the beginning of a message, or several
  std::uint64_t offset_ = 0;  // of `unread_` in the file
  std::string hello_, describe_;
  std::vector<Entry> entries_;
  std::vector<std::size_t> begins_;  // of frames in `entries_`
  bool shapes_ = true;               // the last message was a shape: what follows begins a frame
};

}  // namespace acus::view
