// SPDX-License-Identifier: GPL-3.0-or-later
// A real acus-server on endpoints of its own, with a scene that loads and ticks fast, and what tests do with it.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "client/link/client.h"
#include "tests/integration/process.h"
#include "tests/support/temporary_folder.h"

namespace acus::testing {

using namespace std::chrono_literals;

// Generous: for what happens at once on an idle machine.
inline constexpr std::chrono::milliseconds kPatience = 60s;

// YAML of a scene of 64 nodes with needles of six nodes, far from the tissue.
std::string small_scene(const std::string& name, const std::vector<std::string>& needles = {"needle"});

class ServerProcess {
 public:
  // Starts it on the YAML of a scene. It may not listen yet; clients need not care. `before` is a command that runs the
  // server in its own place, such as prlimit(1).
  explicit ServerProcess(const std::vector<std::string>& options = {},
                         const std::string& scene_text = small_scene("small"), std::vector<std::string> before = {});

  const TemporaryFolder& folder() const { return folder_; }
  std::string scene() const { return folder_ / "scene.yaml"; }
  std::string commands() const { return "ipc://" + (folder_ / "commands"); }
  std::string states() const { return "ipc://" + (folder_ / "states"); }

  // acus-server's command line: scene, both endpoints, then the options.
  std::vector<std::string> command_line(const std::vector<std::string>& options) const;

  Process& process() { return *process_; }

 private:
  TemporaryFolder folder_;
  std::optional<Process> process_;
};

// A link that holds needles and guides, so that it may command them.
client::CommandLink hold(const ServerProcess& server, const std::vector<std::string>& needles = {"needle"});

// A link that listens to the topics for certain: it has seen a `stats`.
client::StateLink subscribe(const ServerProcess& server, const std::vector<std::string>& topics);

// The next state of this type, whatever comes before it; fails the test if none comes.
template <class Message>
Message receive(client::StateLink& states);

// A pose of the needle at (0, 0, height).
protocol::Pose pose_at(double height, std::uint64_t seq, const std::string& needle = "needle");

}  // namespace acus::testing
