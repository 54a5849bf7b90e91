// SPDX-License-Identifier: GPL-3.0-or-later
// The loop of docs/haptics.md, on a real server: it compiles, and presses a needle on a block.
#include <doctest/doctest.h>

#include <chrono>
#include <thread>
#include <variant>

#include "client/haptics/message.h"
#include "client/haptics/simulated_device.h"
#include "client/link/client.h"
#include "tests/haptics/block_scene.h"
#include "tests/integration/server_process.h"

using namespace acus;

// Puts a device on a needle for so long (s).
void render(haptics::Device& device, client::CommandLink& commands, client::StateLink& states,
            const protocol::NeedleInfo& needle, double seconds) {
  using Clock = std::chrono::steady_clock;
  const haptics::DeviceProperties properties = device.open();
  const haptics::Pose base = haptics::pose_of(needle.base_position, needle.base_orientation);
  haptics::KitOptions options;
  options.workspace.world_from_device = base.orientation;  // the device's x is the needle's
  haptics::Kit kit(properties, options);
  kit.begin(device.read().pose, base);
  const auto begin = Clock::now();
  auto last = begin;
  for (int sample = 0; sample < seconds * properties.rate; ++sample) {
    const std::chrono::duration<double> now(sample / properties.rate);
    std::this_thread::sleep_until(begin + now);
    while (const auto state = states.receive(client::Timeout(0)))
      if (const auto* message = std::get_if<protocol::Haptics>(&*state)) kit.take(haptics::model_of(*message));
    const haptics::Device::Reading reading = device.read();
    const std::chrono::duration<double> elapsed(Clock::now() - last);  // a late sample is to be told
    last = Clock::now();
    const haptics::Kit::Answer answer = kit.step({reading.pose, reading.clutch, elapsed.count()});
    device.write(answer.on_hand);
    if (!commands.send(haptics::message_of(needle.name, answer, now.count())))
      continue;  // what is felt fades by itself
  }
  device.close();
}

TEST_CASE("the loop of the page runs" * doctest::test_suite("clock")) {
  testing::ServerProcess server({}, testing::block_scene("{interaction: {puncture_force: .inf}}", 0.1505, 1000));

  client::CommandLink commands(server.commands());
  client::StateLink states(server.states());
  const protocol::HelloReply hello = commands.hello(client::Timeout(10'000));
  commands.acquire({hello.needles[0].name}, client::Timeout(10'000));
  states.subscribe(protocol::Haptics::kType);
  const auto begin = std::chrono::steady_clock::now();
  haptics::SimulatedDevice device({}, 1000, {.depth = 0.01, .speed = 0.05, .rest = 0.2}, [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  });
  render(device, commands, states, hello.needles[0], 0.5);
  CHECK(device.handle().made() < 1e-3);
  states.subscribe(protocol::Force::kType);
  while (const auto state = states.receive(client::Timeout(10'000)))
    if (const auto* force = std::get_if<protocol::Force>(&*state)) {
      CHECK(force->seq > 0);               // poses arrived
      CHECK(force->base_force[2] > 0.05);  // N, up: the needle was pressed on the block
      break;
    }
}
