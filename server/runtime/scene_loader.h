// SPDX-License-Identifier: GPL-3.0-or-later
// Builds worlds, and destroys them, on threads of its own: loading a scene takes seconds, freeing one milliseconds, and
// neither the simulation nor the socket thread has them to spare.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "server/runtime/loaded_scene.h"
#include "server/runtime/privileges.h"
#include "server/runtime/wakeup.h"

namespace acus {

struct LoadResult {
  std::unique_ptr<LoadedScene> world;  // null if the scene cannot be used
  std::string error;                   // why, then
};

class SceneLoader {
 public:
  // `done` is signalled when a result is there; `rate` (Hz) replaces that of every scene.
  SceneLoader(Wakeup& done, std::optional<double> rate) : done_(done), rate_(rate) {}

  bool busy() const { return loading_.valid(); }

  // Begins to load. Must not be busy.
  void start(const std::string& scene_path) {
    std::promise<LoadResult> promise;
    loading_ = promise.get_future();
    loader_ = std::jthread([this, scene_path, result = std::move(promise)]() mutable {
      lower_priority();
      result.set_value(load(scene_path));
      done_.signal();
    });
  }

  // The result, once it is there; then it is no longer busy.
  std::optional<LoadResult> take() {
    if (!busy() || loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
    return loading_.get();
  }

  void destroy(std::unique_ptr<LoadedScene> world) {
    destroying_ = std::async(std::launch::async, [doomed = std::move(world)]() mutable {
      lower_priority();
      doomed.reset();
    });
  }

 private:
  LoadResult load(const std::string& scene_path) const {
    try {
      return {load_scene(scene_path, rate_), ""};
    } catch (const std::exception& error) {
      return {nullptr, error.what()};
    }
  }

  Wakeup& done_;
  const std::optional<double> rate_;
  std::future<LoadResult> loading_;
  std::jthread loader_;
  std::future<void> destroying_;
};

}  // namespace acus
