// SPDX-License-Identifier: GPL-3.0-or-later
// The file of a server's snapshots: the newest whole one, whatever happens while the next is being written. It is
// written beside the file, brought to the disk and put in its place. On a thread of its own, as disks may take seconds.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <string>

#include "server/engine/state/state.h"

namespace acus {

class SnapshotFile {
 public:
  // Empty: there is none.
  explicit SnapshotFile(std::string path) : path_(std::move(path)) {}

  // Whether it can take a snapshot now.
  bool ready() const;
  // Of a scene with this fingerprint. What goes wrong is logged.
  void write(std::uint64_t fingerprint, std::unique_ptr<State> state);

 private:
  const std::string path_;
  std::future<void> writing_;
};

}  // namespace acus
