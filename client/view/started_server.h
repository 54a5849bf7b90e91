// SPDX-License-Identifier: MIT
// An acus-server of one's own, for one scene, that ends with its owner.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "client/view/server_link.h"

namespace acus::view {

class StartedServer {
 public:
  static constexpr int kNoProgram = 127;  // exit status

  // The acus-server beside the running program. Returns at once; throws std::runtime_error if it cannot be started.
  StartedServer(const std::string& scene, const std::vector<std::string>& options);
  ~StartedServer();  // ends it, and waits
  StartedServer(const StartedServer&) = delete;
  StartedServer& operator=(const StartedServer&) = delete;

  ServerAddress address() const;

  // Its exit status once it has ended, before that -1.
  int ended();

 private:
  std::string folder_;
  pid_t process_ = -1;
  int status_ = -1;
};

}  // namespace acus::view
