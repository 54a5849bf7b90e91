// SPDX-License-Identifier: GPL-3.0-or-later
// A real acus-server on ports of loopback that the system chooses.
#pragma once

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/integration/printed.h"
#include "tests/integration/server_process.h"
#include "tests/support/places.h"

namespace acus::testing {

class TcpServer {
 public:
  // Waits until it listens. `before` is a command that runs the server in its own place, such as prlimit(1).
  explicit TcpServer(std::vector<std::string> before = {})
      : server_(command_line(std::move(before))), commands_(read("commands on ")), states_(read("states on ")) {}

  const std::string& commands() const { return commands_; }
  const std::string& states() const { return states_; }
  Process& process() { return server_.process(); }

 private:
  std::vector<std::string> command_line(std::vector<std::string> line) const {
    folder_.write("scene.yaml", small_scene("small"));
    line.insert(line.end(), {program_path("acus-server"), folder_ / "scene.yaml", "--commands", "tcp://127.0.0.1:*",
                             "--states", "tcp://127.0.0.1:*"});
    return line;
  }
  std::string read(const std::string& before) {
    std::string line;
    do line = server_.read_line();
    while (!line.empty() && line.find(before) == std::string::npos);
    REQUIRE(!line.empty());
    return line.substr(line.find(before) + before.size());
  }

  TemporaryFolder folder_;
  Printed server_;
  std::string commands_, states_;
};

}  // namespace acus::testing
