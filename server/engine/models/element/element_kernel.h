// SPDX-License-Identifier: GPL-3.0-or-later
// Sums over the tetrahedra of a mesh, eight at a time, compiled for each instruction set (kernel_set.h).
// Positions, velocities and forces have four numbers per node, the last unused.
#pragma once

#include <cstddef>

#include "server/engine/math/lanes.h"
#include "server/engine/models/element/corotational_tetrahedron.h"

namespace acus {

// kLanes elements side by side; unfilled lanes repeat the last element with zero volume.
struct ElementBatch {
  TetrahedronShape<Octet> shape;
  int nodes[4][kLanes];
};

// Their rotations as quaternions (w, x, y, z).
struct RotationBatch {
  Octet q[4];
};

// The patches (nodal_pressure.h) of their nodes.
struct PatchBatch {
  int patches[4][kLanes];
};

// A symmetric strain of each: xx, yy, zz, xy, xz, yz.
struct StrainBatch {
  Octet at[6];
};

// What elements remember (tissue_memory.h): per batch and branch.
struct MemoryArrays {
  int branches;
  const Octet* stiffening;   // per batch: G
  const Octet* given;        // g (1 - alpha)
  const StrainBatch* crept;  // z
};

// All elements of a mesh.
struct ElementArrays {
  std::size_t count;  // batches
  const ElementBatch* shapes;
  const Octet* damping = nullptr;        // beta (s)
  const PatchBatch* patches = nullptr;   // null: there are none
  const MemoryArrays* memory = nullptr;  // null: nothing is remembered
};

struct ElementKernel {
  // forces += dPsi/dx (N) and volume_changes[patch] += V_e/4 theta_e (m³) of each element at positions x (m), whose
  // rotation is found from that in `start`. Returns whether all are upright: none flat or inside out.
  bool (*elastic_forces)(const ElementArrays& elements, const double* x, const RotationBatch* start,
                         RotationBatch* rotations, double* forces, double* volume_changes);
  // Those who remember: crept <- z + alpha (E - z) with the strain E at x, alpha as `taken`, and forces += what that
  // changes of the elastic forces (N). Rotations stay.
  void (*relax)(const ElementArrays& elements, const double* x, const RotationBatch* rotations, const Octet* taken,
                StrainBatch* crept, double* forces);
  // forces += R beta K0 Rᵀ v (N), volume_changes[patch] += V_e/4 times the rate of theta_e (m³/s).
  void (*damping_forces)(const ElementArrays& elements, const double* v, const RotationBatch* rotations, double* forces,
                         double* volume_changes);
  // forces += what the mean pressures of each element's patches add (N); pressures in Pa, one per patch.
  void (*pressure_forces)(const ElementArrays& elements, const double* pressures, const RotationBatch* rotations,
                          double* forces);
  // sums[node] += V_e q_e of each element around it. `same_sign`: all quaternions are on one side; otherwise each is
  // added with the sign that it has beside what is there already, for q and -q are the same rotation.
  void (*add_rotations)(const ElementArrays& elements, const RotationBatch* rotations, bool same_sign, double* sums);
  // Whether w is larger than `least` in all rotations.
  bool (*all_turned_less)(const ElementArrays& elements, const RotationBatch* rotations, double least);
};

// That of the chosen instruction set.
const ElementKernel& element_kernel();

}  // namespace acus
