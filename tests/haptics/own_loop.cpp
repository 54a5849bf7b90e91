// SPDX-License-Identifier: GPL-3.0-or-later
// The loop of docs/haptics.md, on a real server: what stands there compiles, and the hand feels the tissue.
#include <doctest/doctest.h>

#include <chrono>
#include <thread>
#include <variant>

#include "client/haptics/message.h"
#include "client/haptics/simulated_device.h"
#include "client/link/client.h"
#include "tests/integration/server_process.h"

using namespace acus;

// Puts a device on a needle for so long (s).
void render(haptics::Device& device, client::CommandLink& commands, client::StateLink& states,
            const protocol::NeedleInfo& needle, double seconds) {
  using Clock = std::chrono::steady_clock;
  const haptics::DeviceProperties properties = device.open();
  haptics::Kit kit(properties);
  kit.begin(device.read().pose, haptics::pose_of(needle.base_position, needle.base_orientation));
  const auto begin = Clock::now();
  for (int sample = 0; sample < seconds * properties.rate; ++sample) {
    const std::chrono::duration<double> now(sample / properties.rate);
    std::this_thread::sleep_until(begin + now);
    while (const auto state = states.receive(client::Timeout(0)))
      if (const auto* message = std::get_if<protocol::Haptics>(&*state)) kit.take(haptics::model_of(*message));
    const haptics::Device::Reading reading = device.read();
    const haptics::Kit::Answer answer = kit.step({reading.pose, reading.clutch});
    device.write(answer.on_hand);
    if (!commands.send(haptics::message_of(needle.name, answer, now.count())))
      continue;  // what is felt fades by itself
  }
  device.close();
}

TEST_CASE("the loop of the page runs" * doctest::test_suite("clock")) {
  testing::ServerProcess server({}, R"(acus_scene: 1
tissue:
  mesh:
    box: {size: [0.1, 0.1, 0.1], cells: [3, 3, 3]}
  fixed:
    - box: {max: [.inf, .inf, -0.04]}
needles:
  - length: 0.1
    beams: 5
    base: {position: [0.003, 0.002, 0.1505], orientation: [1, 0, 0, 0]}
)");
  client::CommandLink commands(server.commands());
  client::StateLink states(server.states());
  const protocol::HelloReply hello = commands.hello(client::Timeout(10'000));
  commands.acquire({hello.needles[0].name}, client::Timeout(10'000));
  states.subscribe(protocol::Haptics::kType);
  const auto begin = std::chrono::steady_clock::now();
  haptics::SimulatedDevice device({}, 1000, {.depth = 0.005}, [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  });
  render(device, commands, states, hello.needles[0], 0.5);
  CHECK(device.handle().made() < 1e-3);
  states.subscribe(protocol::Force::kType);
  while (const auto state = states.receive(client::Timeout(10'000)))
    if (const auto* force = std::get_if<protocol::Force>(&*state)) {
      CHECK(force->seq > 0);  // poses arrived
      break;
    }
}
