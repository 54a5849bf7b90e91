// SPDX-License-Identifier: GPL-3.0-or-later
// The acus-server that lies beside the running program, in lockstep on a scene, in a folder of its own. It ends with its
// owner.
#pragma once

#include <sys/types.h>

#include <string>

namespace acus {

class LockstepServer {
 public:
  // `scene`: YAML. It may not listen yet; clients need not care. Throws std::system_error.
  explicit LockstepServer(const std::string& scene);
  ~LockstepServer();
  LockstepServer(const LockstepServer&) = delete;
  LockstepServer& operator=(const LockstepServer&) = delete;

  std::string commands() const { return "ipc://" + folder_ + "/commands"; }
  std::string states() const { return "ipc://" + folder_ + "/states"; }

 private:
  std::string folder_;
  pid_t process_ = 0;
};

}  // namespace acus
