// SPDX-License-Identifier: GPL-3.0-or-later
// The world and its tick. Deterministic: it reads no clock but for the optional stage timing, and the same scene with
// the same commands at the same ticks gives the same bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "server/simulation/report.h"
#include "server/scene/scene.h"

namespace acus {

// Where the base of a needle shall go. Fields that are absent keep their last value.
struct Command {
  std::uint64_t seq = 0;
  std::optional<Pose> pose;    // world, within kMaxPosition, unit orientation without spin
  std::optional<double> spin;  // rad, within kMaxSpin, continuous over many turns, about the needle's +x axis
};

// What a loaded scene has room for, which fixes its memory and bounds the work of a tick.
struct Costs {
  int free_nodes = 0;              // of the tissue, three unknowns each
  std::size_t factor_entries = 0;  // of the tissue's Cholesky factor
  std::size_t factor_bytes = 0;
  int corridor_nodes = 0;          // tissue nodes whose compliance is kept
  int corridor_column = 0;         // entries of each of their three columns, at most
  int max_rows = 0;                // scalar rows of the laws in one tick
};

// What is stored in needles and tissue (J).
struct Energy {
  double kinetic = 0;
  double elastic = 0;    // of elements and beams, and of the rows that give way by themselves
  double potential = 0;  // of gravity, zero at the state after loading

  double total() const { return kinetic + elastic + potential; }
};

// Told before each step of loading a scene what that step makes: "mesh", "regions", ..., "factor", ...
using Progress = std::function<void(const char* what)>;

class Simulation {
 public:
  // Loads the mesh and factorises; throws SceneError.
  explicit Simulation(const Scene& scene, const Progress& progress = {});
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  // The newest command of a needle, or of guide g as number needles + g, taken in by the next tick. Never blocks, never
  // allocates. False for one that is out of range or not finite: it is refused as a whole, the one before stays.
  bool command(int body, const Command& command);

  // One tick of length h = 1/rate: the ten stages. Never throws; trouble is a flag in the report.
  void step();

  // What the scene's `overrun` allows to give way gives way, from the next tick on.
  void economize(bool on);

  // Back to the state after loading, tick 0.
  void reset();

  const TickReport& report() const;

  // Constant after construction.
  const Scene& scene() const;
  const TetrahedralMesh& mesh() const;                   // at its place in the world
  std::span<const int> regions() const;                  // region of each tetrahedron
  int needle_node_count(int needle) const;
  Costs costs() const;

  // Of the current state. Goes through all elements: for tests and studies, not for every tick.
  Energy energy() const;

  // Current state, valid until the next step().
  Eigen::Ref<const Matrix3X> tissue_positions() const;                    // 3 x n, m, world
  Eigen::Ref<const Matrix3X> needle_positions(int needle) const;          // 3 x m, m, world
  std::span<const Quaternion> needle_orientations(int needle) const;      // m, world; +x runs along the needle
  // Paths, those of withdrawn needles included; most of the max_paths() are empty.
  static int max_paths();
  int path_capacity() const;                                  // points that a path can have
  // Writes the points of a path (m, world), mouth first, into the first columns of `points`; returns how many.
  int path_positions(int path, Eigen::Ref<Matrix3X> points) const;

  void time_stages(bool on);  // fill report().stage_seconds

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace acus
