// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/integration/server_process.h"

#include <doctest/doctest.h>

#include "tests/support/places.h"

namespace acus::testing {

std::string small_scene(const std::string& name, const std::vector<std::string>& needles) {
  std::string text = "acus_scene: 1\nname: " + name + R"(
rate: 200
tissue:
  mesh:
    box: {size: [0.1, 0.1, 0.1], cells: [3, 3, 3]}
  fixed:
    - box: {max: [.inf, .inf, -0.05]}
needle_contact: {enabled: false}  # all are at one place
needles:
)";
  for (const std::string& needle : needles) {
    text += "  - name: " + needle + R"(
    length: 0.1
    beams: 5
    base: {position: [0, 0, 0.5]}
)";
  }
  return text;
}

ServerProcess::ServerProcess(const std::vector<std::string>& options, const std::string& scene_text,
                             std::vector<std::string> before) {
  folder_.write("scene.yaml", scene_text);
  for (std::string& word : command_line(options)) before.push_back(std::move(word));
  process_.emplace(before);
}

std::vector<std::string> ServerProcess::command_line(const std::vector<std::string>& options) const {
  std::vector<std::string> line{program_path("acus-server"), scene(), "--commands", commands(), "--states", states()};
  line.insert(line.end(), options.begin(), options.end());
  return line;
}

client::StateLink subscribe(const ServerProcess& server, const std::vector<std::string>& topics) {
  client::StateLink states(server.states());
  for (const std::string& topic : topics) states.subscribe(topic);
  states.subscribe("stats");
  receive<protocol::Stats>(states);
  return states;
}

template <class Message>
Message receive(client::StateLink& states) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < deadline) {
    const std::optional<protocol::State> state = states.receive(1s);
    if (state && std::holds_alternative<Message>(*state)) return std::get<Message>(*state);
  }
  FAIL("no ", Message::kType, " came");
  return {};
}

template protocol::Force receive(client::StateLink&);
template protocol::NeedleShape receive(client::StateLink&);
template protocol::TissueShape receive(client::StateLink&);
template protocol::Event receive(client::StateLink&);
template protocol::Stats receive(client::StateLink&);
template protocol::Haptics receive(client::StateLink&);

client::CommandLink hold(const ServerProcess& server, const std::vector<std::string>& needles) {
  client::CommandLink commands(server.commands());
  commands.acquire(needles, kPatience);
  return commands;
}

protocol::Pose pose_at(double height, std::uint64_t seq, const std::string& needle) {
  protocol::Pose pose;
  pose.needle = needle;
  pose.seq = seq;
  pose.position = {0, 0, height};
  return pose;
}

}  // namespace acus::testing
