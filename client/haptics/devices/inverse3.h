// SPDX-License-Identifier: MIT
// Haply's Inverse3, with or without a VerseGrip, through Haply's Inverse Service: JSON over a WebSocket, by default at
// ws://localhost:10001, as public client code has it. The service sends one message a cycle,
//
//   {"inverse3": [{"device_id": "...", "state": {"cursor_position": {"x":, "y":, "z":}, ...}}],
//    "wireless_verse_grip": [{"state": {"orientation": {"x":, "y":, "z":, "w":}, "buttons": {"a":, "b":, "c":}}}]}
//
// in m, and is answered by a force in N:
//
//   {"inverse3": [{"device_id": "...", "commands": {"set_cursor_force": {"values": {"x":, "y":, "z":}}}}]}
//
// Button a of the grip is the clutch. Written from public client code and tested against a stand-in made from it; no
// hardware was at hand. Haply publishes neither mass nor damping of the device: the figures in inverse3.cpp are chosen,
// low, and to be replaced by measured ones.
#pragma once

#include <memory>
#include <string>

#include "client/haptics/device.h"

namespace acus::haptics {

class Inverse3 : public Device {
 public:
  // `address` as ws://HOST:PORT. Throws DeviceError for another form.
  Inverse3(const std::string& address, double rate);
  ~Inverse3() override;

  // Waits for the service, and then for its first message, for two seconds at most each. A message of another form is
  // an error of the next read(); the service has got a force of zero then.
  DeviceProperties open() override;
  Reading read() override;
  void write(const Wrench& wrench) override;
  void close() override;

 private:
  class Link;
  std::string host_, port_;
  double rate_;
  std::unique_ptr<Link> link_;
};

}  // namespace acus::haptics
