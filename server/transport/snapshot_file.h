// SPDX-License-Identifier: GPL-3.0-or-later
// The file of a server's snapshots: the newest whole one, whatever happens while the next is being written. It is
// written beside the file, brought to the disk and put in its place. On a thread of its own, as disks may take seconds;
// one that takes longer is told of, and nobody waits for it. Only one process writes to it, and it replaces nothing but
// snapshots.
#pragma once

#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <string>

#include "server/engine/state/state.h"
#include "server/transport/file_lock.h"

namespace acus {

class SnapshotFile {
 public:
  using Clock = std::chrono::steady_clock;

  // Empty: there is none. Throws NotLocked where another process writes to it.
  explicit SnapshotFile(std::string path);
  // Waits a second for what is being written.
  ~SnapshotFile();
  SnapshotFile(const SnapshotFile&) = delete;
  SnapshotFile& operator=(const SnapshotFile&) = delete;

  // Why snapshots cannot be put there, with the remedy; empty if they can.
  static std::string problem_with(const std::string& path);

  // Whether it can take a snapshot now.
  bool ready() const;
  // Whether one is being written, on a thread that outlives this.
  bool writing() const { return !path_.empty() && !ready(); }
  // Of a scene with this fingerprint. What goes wrong is logged.
  void write(std::uint64_t fingerprint, std::unique_ptr<State> state);
  // Logs, once for each snapshot, that it takes long.
  void tell_if_slow(Clock::time_point now);

 private:
  const std::string path_;
  std::shared_ptr<const FileLock> lock_;  // also of a thread that is still writing
  std::future<void> writing_;
  Clock::time_point begun_;
  bool told_ = false;
};

}  // namespace acus
