// SPDX-License-Identifier: MIT
// What a viewer is still to be sent. States come up to a thousand times a second and leave when the viewer's connection
// has room, at most some sixty times a second:
//
//   force            of each needle, per departure, the states with the smallest and the largest base force and the
//                    last one, in the order of ticks, so that no peak is lost; where a departure is late, one for
//                    each kStep of simulation time, too, so that curves have no gaps; of a delay beyond kMostSteps of
//                    them fewer
//   needle, tissue,  the newest of each needle, or the newest
//   stats, cloud
//   event            all; of those beyond kMostEvents the oldest are left out, and counted
//   anything else    all, as far as kMostOthers and kMostBytes
//
// The bytes are the server's own and shared by all viewers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace acus::view {

// A message of the server, and what has to be known of it.
struct Frame {
  std::string topic;   // as its `type`; empty: an answer, or one that cannot be read
  std::string needle;  // that it is about, if it is about one
  double force = 0;    // N, of a `force`: of the base
  std::shared_ptr<const std::string> bytes;
  double time = 0;  // s of simulation, of a `force`
};

// Of a message of the states socket.
Frame frame_of(std::string_view bytes);

class Outbox {
 public:
  static constexpr std::size_t kMostEvents = 1000, kMostOthers = 1000, kMostNeedles = 256;
  static constexpr std::size_t kMostBytes = 64 << 20;  // of the others
  static constexpr double kStep = 20e-3;               // s
  static constexpr std::size_t kMostSteps = 200;       // of a needle

  void put(const Frame& frame);

  // Takes out all that is to leave now.
  std::vector<std::shared_ptr<const std::string>> take();

  // Events and others that were left out so far.
  std::uint64_t lost() const { return lost_; }

 private:
  struct Counted {
    std::uint64_t at = 0;  // count of frames
    Frame frame;
  };
  struct Forces {
    Counted least, most, last;
    std::vector<Counted> steps;
    double step = kStep, since = 0;  // s: between steps; time of the newest, or of the first frame
  };

  static void add_step(Forces& forces, const Counted& now);

  std::uint64_t count_ = 0, lost_ = 0;
  std::map<std::string, Forces> forces_;                         // by needle
  std::map<std::pair<std::string, std::string>, Frame> newest_;  // by topic and needle
  std::deque<Frame> events_, others_;
  std::size_t other_bytes_ = 0;
};

}  // namespace acus::view
