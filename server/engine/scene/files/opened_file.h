// SPDX-License-Identifier: GPL-3.0-or-later
// Files whose path somebody else may have chosen: what is judged is what is read. The file is held before anything is
// asked of it, so that a link or a pipe put in its place meanwhile changes nothing.
#pragma once

#include <string>

namespace acus {

class SceneFolders;

// Closed when the object goes.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number_(other.number_) { other.number_ = -1; }
  Descriptor& operator=(Descriptor&&) = delete;

  int number() const { return number_; }  // negative: none
  void close();

 private:
  int number_;
};

struct OpenedFile {
  Descriptor file;
  std::string problem;  // why there is none, "No such file or directory"; else empty
};

// A regular file, opened for reading, which touches no device. Neither this nor reading waits: of a file that has
// nothing to give for now, as some of /proc, read() fails. With `allowed`, the path must lead into these folders, and
// the file that was opened must lie in them; throws SceneError if not. `what` is what the file is, "scene". Takes
// /proc.
OpenedFile open_file(const std::string& path, const std::string& what, const SceneFolders* allowed);

}  // namespace acus
