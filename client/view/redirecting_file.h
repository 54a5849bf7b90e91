// SPDX-License-Identifier: MIT
// A page in a file that only its owner can read and that leads on to a URL, for what must not stand on a command line,
// which every user of the machine can see. It goes away with the object.
#pragma once

#include <string>

namespace acus::view {

class RedirectingFile {
 public:
  // Throws std::system_error where it cannot be made.
  explicit RedirectingFile(const std::string& url);
  ~RedirectingFile();
  RedirectingFile(const RedirectingFile&) = delete;
  RedirectingFile& operator=(const RedirectingFile&) = delete;

  std::string path() const { return folder_ + "/open.html"; }

 private:
  std::string folder_;
};

}  // namespace acus::view
