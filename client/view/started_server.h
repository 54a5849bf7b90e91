// SPDX-License-Identifier: MIT
// An acus-server of one's own, for one scene, that ends with its owner.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/view/child_program.h"
#include "client/view/server_link.h"

namespace acus::view {

class StartedServer {
 public:
  // The acus-server beside the running program. Returns at once; throws std::system_error if it cannot be started.
  StartedServer(boost::asio::io_context& context, const std::string& scene, const std::vector<std::string>& options,
                ChildProgram::Ended ended);
  ~StartedServer();  // ends it, and waits; says where recordings are, if there are any
  StartedServer(const StartedServer&) = delete;
  StartedServer& operator=(const StartedServer&) = delete;

  ServerAddress address() const;
  const std::string& folder() const { return folder_; }  // of its sockets, and of its recordings

 private:
  std::string folder_;
  std::optional<ChildProgram> program_;
};

}  // namespace acus::view
