// SPDX-License-Identifier: MIT
#include "client/view/started_server.h"

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

namespace acus::view {

StartedServer::StartedServer(boost::asio::io_context& context, const std::string& scene,
                             const std::vector<std::string>& options, ChildProgram::Ended ended)
    : folder_(new_folder()) {
  std::vector<std::string> arguments{scene,          "--commands", address().commands, "--states", address().states,
                                     "--recordings", folder_};
  arguments.insert(arguments.end(), options.begin(), options.end());
  program_.emplace(context, "acus-server", std::move(arguments), std::move(ended));
}

StartedServer::~StartedServer() {
  program_.reset();
  std::error_code error;
  bool recordings = false;
  for (std::filesystem::directory_iterator each(folder_, error), end; !error && each != end; each.increment(error))
    if (each->is_regular_file(error)) recordings = true;
  if (recordings) {
    std::fprintf(stderr, "acus-view: recordings that nobody saved are in %s\n", folder_.c_str());
  } else {
    std::filesystem::remove_all(folder_, error);
  }
}

ServerAddress StartedServer::address() const {
  return {"ipc://" + folder_ + "/commands", "ipc://" + folder_ + "/states", std::nullopt};
}

}  // namespace acus::view
