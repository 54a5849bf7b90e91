// SPDX-License-Identifier: MIT
#include <client/link/client.h>
#include <client/haptics/kit.h>

#include <cstdio>

// A device that holds still in free air is rendered nothing.
bool feels_nothing() {
  acus::haptics::Kit kit{acus::haptics::DeviceProperties{}};
  kit.begin({}, {});
  return norm(kit.step({}).on_hand.force) == 0;
}

int main() {
  if (!feels_nothing()) return 1;
  try {
    acus::client::CommandLink commands("tcp://127.0.0.1:9");  // the discard port: nobody answers
    commands.hello(acus::client::Timeout(50));
  } catch (const acus::client::Vanished& error) {
    std::puts(error.what());
    return 0;
  }
  return 1;
}
