// SPDX-License-Identifier: MIT
#include "client/view/started_server.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace acus::view {

StartedServer::StartedServer(boost::asio::io_context& context, const std::string& scene,
                             const std::vector<std::string>& options, ChildProgram::Ended ended) {
  folder_ = (std::filesystem::temp_directory_path() / "acus-view-XXXXXX").string();
  if (mkdtemp(folder_.data()) == nullptr)
    throw std::system_error(errno, std::system_category(), "a folder for the server's sockets");
  std::vector<std::string> arguments{scene,          "--commands", address().commands, "--states", address().states,
                                     "--recordings", folder_};
  arguments.insert(arguments.end(), options.begin(), options.end());
  program_.emplace(context, "acus-server", std::move(arguments), std::move(ended));
}

StartedServer::~StartedServer() {
  program_.reset();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

ServerAddress StartedServer::address() const {
  return {"ipc://" + folder_ + "/commands", "ipc://" + folder_ + "/states", std::nullopt};
}

}  // namespace acus::view
