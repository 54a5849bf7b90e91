// SPDX-License-Identifier: GPL-3.0-or-later
// Builds worlds, and destroys them, on threads of its own: loading a scene takes seconds, freeing one milliseconds, and
// neither the simulation nor the socket thread has them to spare. A thread that loads cannot be stopped: it outlives a
// loader that goes, uses nothing of it, and ends with the process.
#pragma once

#include <future>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <thread>

#include "server/engine/scene/files/scene_folders.h"
#include "server/runtime/is_ready.h"
#include "server/runtime/loaded_scene.h"
#include "server/runtime/privileges.h"
#include "server/runtime/wakeup.h"

namespace acus {

struct LoadResult {
  std::unique_ptr<LoadedScene> world;  // null if the scene cannot be used
  std::string error;                   // why, then
};

// What a client asks for.
struct SceneSource {
  std::string path;  // on this machine, or a name in the folders that clients may load from; or
  std::string text;  // YAML, whose mesh lies in the first of the folders that clients may load from
};

class SceneLoader {
 public:
  // `done` is signalled when a result is there; `rate` (Hz) replaces that of every scene. Nothing outside `folders` is
  // read. `locks`: new memory of the process is locked after each load.
  SceneLoader(Wakeup& done, std::optional<double> rate, SceneFolders folders, bool locks)
      : done_(std::make_shared<Done>(done)), rate_(rate), folders_(std::move(folders)), locks_(locks) {}
  ~SceneLoader() {
    done_->disconnect();
    if (busy() && !is_ready(loading_)) loader_.detach();
  }
  SceneLoader(const SceneLoader&) = delete;
  SceneLoader& operator=(const SceneLoader&) = delete;

  bool busy() const { return loading_.valid(); }

  // Begins to load. Must not be busy. Throws std::system_error where the system gives no thread; it is not busy then.
  void start(const SceneSource& source) {
    std::promise<LoadResult> promise;
    std::future<LoadResult> loading = promise.get_future();
    loader_ = std::jthread([source, rate = rate_, folders = folders_, locks = locks_, done = done_,
                            result = std::move(promise)]() mutable {
      lower_priority();
      LoadResult loaded = load(source, rate, folders);
      if (locks) lock_new_memory();
      result.set_value(std::move(loaded));
      done->signal();
    });
    loading_ = std::move(loading);
  }

  // The result, once it is there; then it is no longer busy.
  std::optional<LoadResult> take() {
    if (!busy() || !is_ready(loading_)) return std::nullopt;
    return loading_.get();
  }

  // Where the system gives no thread, the calling one does it.
  void destroy(std::unique_ptr<LoadedScene> world) {
    try {
      destroying_ = std::async(std::launch::async, [doomed = std::move(world)]() mutable {
        lower_priority();
        doomed.reset();
      });
    } catch (const std::system_error&) {  // the world went with what the thread should have done
    }
  }

 private:
  // Of a result, to whom it is still of interest.
  class Done {
   public:
    explicit Done(Wakeup& wakeup) : wakeup_(&wakeup) {}
    void signal() {
      const std::scoped_lock lock(mutex_);
      if (wakeup_) wakeup_->signal();
    }
    void disconnect() {
      const std::scoped_lock lock(mutex_);
      wakeup_ = nullptr;
    }

   private:
    std::mutex mutex_;
    Wakeup* wakeup_;
  };

  static LoadResult load(const SceneSource& source, std::optional<double> rate, const SceneFolders& folders) {
    try {
      return {load_scene(read(source, folders), rate, &folders), ""};
    } catch (const std::bad_alloc&) {
      return {nullptr, "there is not enough memory for this scene beside the one that goes on; make its mesh coarser"};
    } catch (const std::exception& error) {
      return {nullptr, error.what()};
    }
  }

  static Scene read(const SceneSource& source, const SceneFolders& folders) {
    if (source.text.empty()) return read_scene(folders.find(source.path), &folders);
    return parse_scene(source.text, "the scene's text", folders.first().string(), &folders);
  }

  const std::shared_ptr<Done> done_;
  const std::optional<double> rate_;
  const SceneFolders folders_;
  const bool locks_;
  std::future<LoadResult> loading_;
  std::jthread loader_;
  std::future<void> destroying_;
};

}  // namespace acus
