// SPDX-License-Identifier: MIT
// Where what the pages show comes from: a server, or a recording.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "client/view/outbox.h"

namespace acus::view {

class Source {
 public:
  using Bytes = std::shared_ptr<const std::string>;
  struct Listener {
    std::function<void(const Frame&)> state;   // as on the states socket
    std::function<void(const Frame&)> answer;  // to what drive() sent
    std::function<void()> arrived;             // here() has become true
  };

  virtual ~Source() = default;

  // Whether there is something to show.
  virtual bool here() const = 0;
  virtual bool lockstep() const = 0;
  // The newest `hello_reply` and the `describe_reply` of its scene, as they came; null: none yet.
  virtual Bytes hello() const = 0;
  virtual Bytes describe() const = 0;

  // Whether states are asked for: only while somebody looks.
  virtual void watch(bool wanted) = 0;

  // Commands of one viewer. What it holds is released when it ends. Nothing happens while no server is here.
  virtual void begin_driving() = 0;
  virtual void end_driving() = 0;
  virtual void drive(std::string_view message) = 0;
};

}  // namespace acus::view
