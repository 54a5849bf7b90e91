// SPDX-License-Identifier: GPL-3.0-or-later
// A loaded scene and its tick: model, state, scratch and report together. Deterministic: it reads no clock but for the
// optional stage timing, and the same scene with the same commands at the same ticks gives the same bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "server/engine/state/report.h"
#include "server/engine/state/state.h"
#include "server/engine/tick/base_stiffness.h"
#include "server/engine/tick/scratch.h"

namespace acus {

// What a loaded scene has room for, which fixes its memory and bounds the work of a tick.
struct Costs {
  int free_nodes = 0;              // of the tissue, three unknowns each
  std::size_t factor_entries = 0;  // of the tissue's Cholesky factor
  std::size_t factor_bytes = 0;
  int corridor_nodes = 0;          // tissue nodes whose compliance is kept
  int corridor_column = 0;         // entries of each of their three columns, at most
  int window = 0;                  // ticks of the deferred field; without one the next four are 0
  int modes = 0;                   // that carry its inertia
  bool about_equilibrium = false;  // its matrix is that of the equilibrium, not of the rest shape
  double slice = 0;                // of its work in a tick, in entries of the factor: the mean,
  double largest_slice = 0;        // and the largest
  int max_rows = 0;                // scalar rows of the laws in one tick
  int max_tick_steps = 0;          // times that a tick may solve, of Scene::laws.max_steps steps each
};

// What is stored in needles and tissue (J).
struct Energy {
  double kinetic = 0;
  double elastic = 0;    // of elements and beams, and of the rows with a compliance
  double potential = 0;  // of gravity and pressures, zero at the state after loading

  double total() const { return kinetic + elastic + potential; }
};

class Simulation {
 public:
  // Factorises, with the scene's mesh as read_mesh() gives it, or reads that first; throws SceneError.
  explicit Simulation(const Scene& scene, const Progress& progress = {}, std::optional<TetrahedralMesh> own_mesh = {});
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  // The newest command of a needle, or of guide g as number needles + g, taken in by the next tick. Never blocks, never
  // allocates. False for one that is out of range or not finite: it is refused as a whole, the one before stays.
  bool command(int body, const Command& command);
  // Commands it to come to rest where it is; returns the command.
  Command come_to_rest(int body);

  // One tick of length h = 1/rate: the ten stages. Never throws; trouble is a flag in the report. Commands that came in are
  // used up, also by a tick that is refused.
  void step();

  // Whether iterations are reduced, as the scene's `overrun` allows, from the next tick on.
  void economize(bool on) { state_.economizing = on; }

  // Back to the state after loading, tick 0.
  void reset();

  const TickReport& report() const { return report_; }

  // How the wrenches that the last tick reports depend on where the bases are, of one needle after the other, valid
  // until the next step(). All zero where there was none. Costs the more the more rows there are, and only those who
  // ask.
  std::span<const BaseStiffness> base_stiffnesses();

  // Where a needle's base, or guide g as number needles + g, is, and where it goes.
  const BaseState& motion(int body) const;

  // Constant after construction.
  const Model& model() const { return model_; }
  const Scene& scene() const { return model_.scene; }
  const TetrahedralMesh& mesh() const { return model_.mesh; }                 // at its place in the world
  std::span<const int> regions() const { return model_.regions; }             // region of each tetrahedron
  int needle_node_count(int needle) const { return model_.needles[needle].nodes(); }
  Costs costs() const;
  // Processor time that the thread of tissue.window_thread took for its last window (s); 0: there was none.
  double window_seconds() const;

  const State& state() const { return state_; }
  // Goes on from a state of the same scene. Commands that wait are dropped; the report is as after a reset, at the state's
  // tick.
  void restore(const State& state);

  // Of the current state. Goes through all elements: for tests and studies, not for every tick.
  Energy energy() const;

  // Current state, valid until the next step().
  Eigen::Ref<const Matrix3X> tissue_positions() const { return state_.tissue.x; }                          // 3 x n, m
  Eigen::Ref<const Matrix3X> needle_positions(int needle) const { return state_.needles[needle].x; }       // 3 x m, m
  // World; +x runs along the needle.
  std::span<const Quaternion> needle_orientations(int needle) const { return state_.needles[needle].q; }
  // Paths, those of withdrawn needles included; most of the max_paths() are empty.
  static int max_paths();
  int path_capacity() const { return model_.path_vertices + 1; }  // points that a path can have
  // Writes the points of a path (m, world), mouth first, into the first columns of `points`; returns how many.
  int path_positions(int path, Eigen::Ref<Matrix3X> points) const;

  // Fill stage_seconds() from the next tick on.
  void time_stages(bool on) { scratch_->times.wanted = on; }
  const std::array<double, kStageCount>& stage_seconds() const { return scratch_->times.seconds; }
  // What the laws of the last tick took.
  const LawSteps& law_steps() const { return scratch_->outcome.law_steps; }

 private:
  void begin_report();
  double potential_energy() const;

  const std::optional<State> settled_;  // what reset() goes back to, if the scene starts in equilibrium
  const Model model_;
  State state_;
  Commands commands_;
  std::unique_ptr<Scratch> scratch_;
  BaseStiffnessSolver stiffness_solver_;
  std::vector<BaseStiffness> stiffnesses_;
  bool ticked_ = false;  // since the state was put in
  TickReport report_;
  double potential_at_start_;  // J
};

}  // namespace acus
