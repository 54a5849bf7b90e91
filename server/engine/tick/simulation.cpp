// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/simulation.h"

#include <algorithm>
#include <cassert>

#include "server/engine/state/limits.h"
#include "server/engine/tick/static_start.h"
#include "server/engine/tick/step.h"

namespace acus {

Simulation::Simulation(const Scene& scene, const Progress& progress, std::optional<TetrahedralMesh> own_mesh)
    : settled_(settle(scene, progress, own_mesh)),
      model_(scene, progress, std::move(own_mesh), tissue_of(settled_)),
      state_(start_state(model_, settled_)),
      commands_(scene.needles.size() + scene.guides.size()),
      scratch_(std::make_unique<Scratch>(model_, progress)),
      stiffness_solver_(model_),
      stiffnesses_(scene.needles.size()),
      potential_at_start_(potential_energy()) {
  report_.needles.resize(scene.needles.size());
  report_.events.reserve(scratch_->events.capacity());
  begin_report();
}

Command Simulation::come_to_rest(int body) {
  const int guide = body - model_.needle_count();
  const BaseLimits& limits = guide < 0 ? model_.needle_limits[body] : model_.guide_limits[guide];
  const Command rest = acus::come_to_rest(limits, motion(body));
  command(body, rest);
  return rest;
}

const BaseState& Simulation::motion(int body) const {
  const int guide = body - model_.needle_count();
  return guide < 0 ? state_.bases[body] : state_.guides[guide].motion;
}

std::span<const BaseStiffness> Simulation::base_stiffnesses() {
  std::ranges::fill(stiffnesses_, BaseStiffness{});
  if (!ticked_ || !scratch_->outcome.finite) return stiffnesses_;
  stiffness_solver_.begin(*scratch_);
  for (int i = 0; i < model_.needle_count(); ++i) stiffnesses_[i] = stiffness_solver_.compute(model_, *scratch_, i);
  return stiffnesses_;
}

bool Simulation::command(int body, const Command& command) {
  assert(body >= 0 && body < static_cast<int>(commands_.size()));
  if (!in_range(command)) return false;
  merge(commands_[body], command);
  return true;
}

void Simulation::step() {
  acus::step(model_, commands_, state_, *scratch_, report_);
  ticked_ = true;
  std::fill(commands_.begin(), commands_.end(), std::nullopt);
}

void Simulation::reset() {
  restore(start_state(model_, settled_));
  scratch_->tissue.rows->corridor().clear();
}

void Simulation::restore(const State& state) {
  assert(state.tissue.x.cols() == model_.mesh.node_count() && state.needles.size() == model_.needles.size());
  state_ = state;
  std::fill(commands_.begin(), commands_.end(), std::nullopt);
  std::fill(scratch_->next_look.begin(), scratch_->next_look.end(), 0);
  begin_report();
  ticked_ = false;
}

// Before the first tick. Keeps the lists' memory.
void Simulation::begin_report() {
  TickReport fresh;
  fresh.needles = std::move(report_.needles);
  fresh.events = std::move(report_.events);
  std::fill(fresh.needles.begin(), fresh.needles.end(), NeedleReport{});
  fresh.events.clear();
  report_ = std::move(fresh);
  report_state(model_, state_, report_);
}

Costs Simulation::costs() const {
  const SparseCholesky& factor = model_.tissue_system.factor;
  Costs costs{.free_nodes = static_cast<int>(model_.tissue.free_nodes.size()),
              .factor_entries = factor.factor_entries(),
              .factor_bytes = factor.factor_bytes(),
              .corridor_nodes = scratch_->tissue.rows->corridor().capacity(),
              .corridor_column = factor.tree().longest_way,
              .max_rows = model_.max_rows,
              .max_tick_steps = model_.max_tick_steps()};
  if (const auto& field = model_.tissue_system.field) {
    const FieldTask& task = scratch_->tissue.field->worker.task();
    costs.window = field->window;
    costs.about_equilibrium = field->about_equilibrium;
    costs.modes = static_cast<int>(field->modes.count());
    costs.slice = task.cost() / field->window;
    costs.largest_slice = task.largest_slice(field->window);
  }
  return costs;
}

double Simulation::window_seconds() const {
  const auto& field = scratch_->tissue.field;
  return field ? field->worker.thread_seconds() : 0;
}

double Simulation::potential_energy() const {
  double energy = acus::potential_energy(model_.tissue, state_.tissue);
  for (int i = 0; i < model_.needle_count(); ++i)
    energy += acus::potential_energy(model_.needles[i], state_.needles[i]);
  return energy;
}

Energy Simulation::energy() const {
  Energy energy;
  energy.kinetic = kinetic_energy(model_.tissue, state_.tissue);
  energy.elastic = elastic_energy(model_.tissue_system, state_.tissue) + state_.spring_energy;
  energy.potential = potential_energy() - potential_at_start_;
  NeedleShape shape;
  for (int i = 0; i < model_.needle_count(); ++i) {
    put_shape(state_.needles[i], shape);
    energy.kinetic += kinetic_energy(model_.needles[i], state_.needles[i]);
    energy.elastic += elastic_energy(model_.needles[i], shape);
  }
  return energy;
}

int Simulation::max_paths() { return kMaxPaths; }

int Simulation::path_positions(int path, Eigen::Ref<Matrix3X> points) const {
  const Path& p = state_.paths[path];
  for (int i = 0; i < p.points(); ++i)
    points.col(i) = material_position(model_.mesh, state_.tissue.x, p.point(i));
  return p.points();
}

}  // namespace acus
