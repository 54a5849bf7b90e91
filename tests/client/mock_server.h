// SPDX-License-Identifier: GPL-3.0-or-later
// A scripted peer for client tests: it speaks the wire protocol on free loopback ports from a thread of its own, has no
// physics, and misbehaves on request.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "protocol/messages.h"

namespace acus::test {

struct MockScript {
  std::vector<std::string> needles{"needle"};
  std::vector<std::string> guides;
  bool lockstep = false;
  bool paused = false;
  double rate = 200;                        // Hz, of the ticks, as it says
  double pace = 1;                          // of this rate, at which they come in real time
  std::uint64_t first_seq = 0;              // in the states before the first pose
  bool mute = false;                        // hears requests, answers none
  std::uint8_t version = protocol::kVersion;  // written into replies
  bool rejects_poses = false;               // answers each with bad_value
  bool rejects_requests = false;            // answers each with busy
  std::uint64_t shape_ticks = 10;           // between two shapes
  bool loses_shapes = false;                // of every second time
  std::uint64_t lossy_pose = 0;             // the force states of the tick after this many poses are not published
  std::optional<std::uint64_t> reset_tick;  // the tick after it is number 1 again
  std::optional<std::uint64_t> last_tick;   // the server disappears after it
};

// A loopback port that the system gives to nobody else while this lives. It does not listen: who binds with
// SO_REUSEADDR, as ZeroMQ does, may listen there, and until then connections are refused.
class ReservedPort {
 public:
  ReservedPort();
  ~ReservedPort();
  ReservedPort(const ReservedPort&) = delete;
  ReservedPort& operator=(const ReservedPort&) = delete;

  const std::string& endpoint() const { return endpoint_; }

 private:
  int socket_;
  std::string endpoint_;
};

class MockServer {
 public:
  // Starts after `delay_ms`; the ports are reserved before, so that their names are known.
  explicit MockServer(const MockScript& script = {}, int delay_ms = 0);
  ~MockServer();
  MockServer(const MockServer&) = delete;
  MockServer& operator=(const MockServer&) = delete;

  const std::string& commands() const { return commands_.endpoint(); }
  const std::string& states() const { return states_.endpoint(); }
  std::uint64_t poses() const { return poses_; }  // received
  std::uint64_t ticks() const { return ticks_; }  // run
  bool was_shut_down() const { return was_shut_down_; }

 private:
  void serve(int delay_ms);

  MockScript script_;
  ReservedPort commands_;
  ReservedPort states_;
  std::atomic<std::uint64_t> poses_ = 0;
  std::atomic<std::uint64_t> ticks_ = 0;
  std::atomic<bool> was_shut_down_ = false;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace acus::test
