// SPDX-License-Identifier: MIT
// The tips of acus-cloud (protocol/README.md, "cloud"), of one that runs, or of one that is started with it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/view/child_program.h"
#include "client/view/outbox.h"
#include "client/view/watched_socket.h"

namespace acus::view {

struct CloudOptions {
  int worlds = 0;        // to start acus-cloud with; 0: `endpoint` is that of one that runs
  std::string endpoint;
  std::string scene;     // that the server simulates; empty: not known
};

class CloudLink {
 public:
  // `server`: the options of a program that tell where the server is. `take` gets what comes, `ended` once a sentence if
  // the program has ended. Throws client::ClientError for the endpoint, std::system_error if nothing can be started.
  CloudLink(boost::asio::io_context& context, const CloudOptions& options, const std::vector<std::string>& server,
            std::function<void(const Frame&)> take, std::function<void(const std::string&)> ended);
  ~CloudLink();

 private:
  void start(boost::asio::io_context& context, const CloudOptions& options, const std::string& endpoint,
             const std::vector<std::string>& server, std::function<void(const std::string&)> ended);

  std::string folder_;  // of the socket of the program that was started; empty: none was
  std::optional<ChildProgram> program_;
  std::unique_ptr<WatchedSocket> tips_;
};

}  // namespace acus::view
