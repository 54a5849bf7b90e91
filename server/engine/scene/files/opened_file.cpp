// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/files/opened_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "server/engine/scene/files/scene_folders.h"

namespace acus {

void Descriptor::close() {
  if (number_ >= 0) ::close(number_);
  number_ = -1;
}

OpenedFile open_file(const std::string& path, const std::string& what, const SceneFolders* allowed) {
  if (allowed) allowed->check(path, what);
  const Descriptor held(open(path.c_str(), O_PATH | O_CLOEXEC));
  if (held.number() < 0) return {Descriptor(), std::strerror(errno)};
  const std::string itself = "/proc/self/fd/" + std::to_string(held.number());
  if (allowed) allowed->check_opened(itself, path, what);
  struct stat found {};
  if (fstat(held.number(), &found) != 0) return {Descriptor(), std::strerror(errno)};
  if (!S_ISREG(found.st_mode)) return {Descriptor(), "no regular file, but a folder, a pipe, a socket or a device"};
  Descriptor file(open(itself.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY));
  if (file.number() < 0) return {Descriptor(), itself + ": " + std::strerror(errno)};
  return {std::move(file), ""};
}

}  // namespace acus
