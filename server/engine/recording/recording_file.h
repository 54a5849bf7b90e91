// SPDX-License-Identifier: GPL-3.0-or-later
// A recording's file: items in, a frame of them at a time, and out again.
//
// A frame is written with one call after the one before, and cut off again if that fails: whatever ends the program, the
// frames before are whole.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/engine/recording/recording.h"

namespace acus {

class RecordingWriter {
 public:
  // Creates the file, which must not be there. Throws RecordingError.
  explicit RecordingWriter(std::string path);
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  const std::string& path() const { return path_; }
  std::uint64_t bytes() const { return end_; }  // written

  void add(const recorded::Item& item) { append(pending_, item); }
  std::size_t pending() const { return pending_.size(); }  // bytes that wait for the next frame

  // Writes what was added since the last time. Throws RecordingError, and the file ends where it ended before; also if
  // the file has been removed meanwhile.
  void flush();

 private:
  const std::string path_;
  int file_ = -1;
  std::uint64_t end_ = 0;     // bytes, of the whole frames
  std::string pending_;       // items
  std::vector<char> packed_;  // a frame, reused
};

class RecordingReader {
 public:
  // Throws RecordingError if there is no such file or it is no recording.
  explicit RecordingReader(const std::string& path);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  const recorded::Opening& opening() const { return opening_; }

  // The next item, or nothing at the end. Throws RecordingError for what no recording holds.
  std::optional<recorded::Item> next();

  // Why there was no more, after the end: "" where the recording says itself that it ends there.
  const std::string& problem() const { return problem_; }
  // Whether it is because of a part that is damaged, or not whole, or because something stands behind the end.
  bool damaged() const { return damaged_; }

 private:
  bool read_frame();
  void end(const std::string& why);
  bool fail(const std::string& why);
  bool fill();

  int file_ = -1;
  std::string buffer_;      // of the file, from the next frame on
  std::string unpacked_;    // the frame,
  std::string_view items_;  // and what is left of it
  std::uint64_t offset_ = 0;  // bytes, of buffer_ in the file
  recorded::Opening opening_;
  bool ended_ = false;
  std::string problem_;
  bool damaged_ = false;
};

// Whether a file begins as recordings do, whatever its name. Of a pipe, from which nothing is read, it does not.
bool is_recording(const std::string& path);

// What a recording holds, found without running it again.
struct RecordingLength {
  recorded::Opening opening;
  bool begun = false;    // a state to begin with is there
  double seconds = 0;    // of simulation time: of all its ticks
  double time_step = 0;  // s, of the last of them
  std::string problem;   // as RecordingReader tells them
  bool damaged = false;
};
// Throws RecordingError.
RecordingLength length_of(const std::string& path);

}  // namespace acus
