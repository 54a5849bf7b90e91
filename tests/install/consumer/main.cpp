// SPDX-License-Identifier: MIT
#include <client/client.h>

#include <cstdio>

int main() {
  try {
    acus::client::CommandLink commands("tcp://127.0.0.1:9");  // the discard port: nobody answers
    commands.hello(acus::client::Timeout(50));
  } catch (const acus::client::Vanished& error) {
    std::puts(error.what());
    return 0;
  }
  return 1;
}
