// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/python/engine_state.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "server/engine/tick/base_motion.h"
#include "server/engine/tick/step.h"

namespace acus::python {

namespace {

std::uint64_t next_number() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

template <class Named>
int find(const std::vector<Named>& bodies, const std::string& name) {
  const auto found = std::ranges::find(bodies, name, &Named::name);
  return found == bodies.end() ? -1 : static_cast<int>(found - bodies.begin());
}

std::string names(const Scene& scene) {
  std::string all;
  for (const Needle& needle : scene.needles) all += (all.empty() ? "" : ", ") + needle.name;
  for (const Guide& guide : scene.guides) all += ", " + guide.name;
  return all;
}

}  // namespace

EngineModel::EngineModel(const Scene& scene) : EngineModel(scene, read_mesh(scene)) {}

EngineModel::EngineModel(const Scene& scene, std::optional<TetrahedralMesh> own_mesh)
    : settled_(settle(scene, {}, own_mesh)),
      model_(scene, {}, own_mesh, tissue_of(settled_)),
      world_(std::make_shared<recorded::World>(record_of(scene, *own_mesh, model_.fingerprint))) {}

int EngineModel::needle(const std::string& name) const {
  const int needle = find(scene().needles, name);
  if (needle < 0) throw std::out_of_range("the scene has no needle '" + name + "'; it has " + names(scene()));
  return needle;
}

int EngineModel::body(const std::string& name) const {
  if (const int needle = find(scene().needles, name); needle >= 0) return needle;
  const int guide = find(scene().guides, name);
  if (guide < 0) throw std::out_of_range("the scene has no needle or guide '" + name + "'; it has " + names(scene()));
  return model_.needle_count() + guide;
}

std::unique_ptr<Workspace> EngineModel::lend(std::uint64_t state) {
  std::unique_ptr<Workspace> lent;
  {
    const std::lock_guard lock(mutex_);
    auto found = std::ranges::find(idle_, state, [](const auto& each) { return each->state; });
    if (found == idle_.end() && !idle_.empty()) found = idle_.end() - 1;
    if (found != idle_.end()) {
      lent = std::move(*found);
      idle_.erase(found);
    }
  }
  if (!lent) lent = std::make_unique<Workspace>(model_);
  if (std::exchange(lent->state, state) != state) std::ranges::fill(lent->scratch.next_look, 0);
  return lent;
}

void EngineModel::give_back(std::unique_ptr<Workspace> workspace) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(workspace));
}

EngineState::EngineState(std::shared_ptr<EngineModel> of) : EngineState(of, of->start()) {}

EngineState::EngineState(std::shared_ptr<EngineModel> of, State from)
    : model(std::move(of)), state(std::move(from)), number_(next_number()) {
  report.needles.resize(state.needles.size());
  report_state(model->model(), state, report);
}

void EngineState::step(const std::map<int, Command>& commands, int ticks, std::vector<TickReport>* after,
                       const std::function<bool()>& stop) {
  constexpr auto kBetweenQuestions = std::chrono::milliseconds(50);
  std::unique_ptr<Workspace> workspace = model->lend(number_);
  report.events.reserve(workspace->scratch.events.capacity());
  std::ranges::fill(workspace->commands, std::nullopt);
  for (const auto& [body, command] : commands) {
    merge(workspace->commands[static_cast<std::size_t>(body)], command);
    if (recorder_) recorder_->command(body, command);
  }
  auto asked = std::chrono::steady_clock::now();
  for (int tick = 0; tick < ticks; ++tick) {
    const bool economizing = state.economizing;
    acus::step(model->model(), workspace->commands, state, workspace->scratch, report);
    std::ranges::fill(workspace->commands, std::nullopt);
    record_tick(economizing);
    if (after) after->push_back(report);
    if (const auto now = std::chrono::steady_clock::now(); now - asked > kBetweenQuestions) {
      asked = now;
      if (stop()) break;
    }
  }
  model->give_back(std::move(workspace));
}

void EngineState::record(const std::string& path, const std::string& version) {
  if (recorder_) throw RecordingError("the state is being recorded already; end_recording() first");
  recorder_ = std::make_unique<StateRecorder>(path, version, model->world(), state);
}

void EngineState::end_recording() {
  if (const std::unique_ptr<StateRecorder> recorder = std::move(recorder_)) recorder->end();
}

void EngineState::record_tick(bool economizing) {
  if (!recorder_) return;
  try {
    recorder_->tick(economizing, report, state);
  } catch (...) {
    recorder_.reset();
    throw;
  }
}

}  // namespace acus::python
