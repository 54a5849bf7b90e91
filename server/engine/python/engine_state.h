// SPDX-License-Identifier: GPL-3.0-or-later
// A loaded scene and states of it, as Python holds them: the model is shared, a state is a value, and what a tick needs
// besides is lent by the model, so that states of one model run on several threads at once.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/engine/recording/state_recorder.h"
#include "server/engine/state/model.h"
#include "server/engine/state/report.h"
#include "server/engine/tick/scratch.h"
#include "server/engine/tick/static_start.h"

namespace acus::python {

// The memory of a tick. What it caches is of the state that it served last; no result depends on it.
struct Workspace {
  explicit Workspace(const Model& model)
      : scratch(model), commands(model.needles.size() + static_cast<std::size_t>(model.guide_count())) {}

  Scratch scratch;
  Commands commands;
  std::uint64_t state = 0;  // number of the state that it served last
};

class EngineModel {
 public:
  // Throws SceneError.
  explicit EngineModel(const Scene& scene);

  const Model& model() const { return model_; }
  // For recordings, which hold the scene and its mesh.
  const std::shared_ptr<const recorded::World>& world() const { return world_; }
  const Scene& scene() const { return model_.scene; }
  // After loading, with bodies elsewhere than in the scene; throws PlacementError.
  State start(const std::map<int, Pose>& places = {}) const { return start_state(model_, settled_, places); }
  // Number of the needle, or of the guide after the needles; throws std::out_of_range that says which there are.
  int body(const std::string& name) const;
  int needle(const std::string& name) const;

  // Lends one, preferably that which served this state before; give it back.
  std::unique_ptr<Workspace> lend(std::uint64_t state);
  void give_back(std::unique_ptr<Workspace> workspace);

 private:
  EngineModel(const Scene& scene, std::optional<TetrahedralMesh> own_mesh);

  const std::optional<State> settled_;
  const Model model_;
  const std::shared_ptr<const recorded::World> world_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> idle_;
};

class EngineState {
 public:
  explicit EngineState(std::shared_ptr<EngineModel> of);  // after loading
  EngineState(std::shared_ptr<EngineModel> of, State from);
  // Without the recording.
  EngineState(const EngineState& other) : EngineState(other.model, other.state) { report = other.report; }

  // So many ticks with these commands, by body, which the first of them takes in. Each report goes into `after`, if
  // given. Ends early, between two ticks, where `stop`, asked now and then, says so. Throws RecordingError if the
  // recording cannot be written on: the state is that of the last tick, and is recorded no more.
  void step(const std::map<int, Command>& commands, int ticks, std::vector<TickReport>* after,
            const std::function<bool()>& stop);

  // From now on, until end_recording(), which does nothing where none is made. Throw RecordingError.
  void record(const std::string& path, const std::string& version);
  void end_recording();

  const std::shared_ptr<EngineModel> model;
  State state;
  TickReport report;  // of the last tick
  bool busy = false;  // a thread steps it

 private:
  void record_tick(bool economizing);

  std::unique_ptr<StateRecorder> recorder_;
  const std::uint64_t number_;  // tells it from other states
};

}  // namespace acus::python
