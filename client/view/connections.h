// SPDX-License-Identifier: MIT
// The connections of a gateway, which may outlive it, and how many there may be. Of those that wait, for a request or a
// token, the one that has waited longest ends where another needs its place: idle ones keep nobody out.
#pragma once

#include <functional>
#include <list>
#include <memory>

namespace acus::view {

class Connections {
 public:
  static constexpr int kMost = 256;

  // Whether there may be another one, for which the one that has waited longest is ended if need be.
  bool make_room();

 private:
  friend class Place;
  struct Entry {
    bool counted = true, waiting = false;
    std::function<void()> end;
  };

  int count_ = 0;
  std::list<Entry*> waiting_;  // the longest first
};

// That of one connection.
class Place {
 public:
  explicit Place(std::shared_ptr<Connections> connections);
  Place(Place&&) noexcept = default;
  ~Place();

  // It waits from now on; `end` ends it, but does not destroy this place.
  void wait(std::function<void()> end);
  // It waits no more.
  void serve();

 private:
  std::shared_ptr<Connections> connections_;
  std::unique_ptr<Connections::Entry> entry_;  // null once moved from
};

}  // namespace acus::view
