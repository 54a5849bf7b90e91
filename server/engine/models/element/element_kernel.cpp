// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once for every instruction set: see kernel_set.h for what such files may contain.
#include "server/engine/models/element/element_kernel.h"

namespace acus {
inline namespace ACUS_KERNEL {
namespace {

using NodalLanes = Lanes[4][3];  // [node][axis]

inline void gather(const ElementBatch& batch, const double* nodal, NodalLanes& local) {
  Quad quads[kLanes];
  for (int k = 0; k < 4; ++k) {
    for (int lane = 0; lane < kLanes; ++lane) quads[lane] = load_quad(nodal + 4 * batch.nodes[k][lane]);
    Lanes axes[4];
    transpose(quads, axes);
    for (int i = 0; i < 3; ++i) local[k][i] = axes[i];
  }
}

inline void add_to_nodes(const ElementBatch& batch, const NodalLanes& force, double* total) {
  Quad quads[kLanes];
  for (int k = 0; k < 4; ++k) {
    transpose(force[k][0], force[k][1], force[k][2], 0.0, quads);
    for (int lane = 0; lane < kLanes; ++lane) add_quad(total + 4 * batch.nodes[k][lane], quads[lane]);
  }
}

inline void load(const RotationBatch& rotations, Lanes (&q)[4]) {
  for (int i = 0; i < 4; ++i) q[i] = rotations.q[i];
}

inline void add_volume_change(const PatchBatch& batch, const Lanes& volume_change, double* sums) {
  Octet quarter;
  (0.25 * volume_change).store(quarter.at);
  for (const auto& patches : batch.patches)
    for (int lane = 0; lane < kLanes; ++lane) sums[patches[lane]] += quarter[lane];
}

inline Lanes mean_pressure(const PatchBatch& batch, const double* pressures) {
  const auto& patches = batch.patches;
  Octet sum;
  for (int lane = 0; lane < kLanes; ++lane)
    sum[lane] = pressures[patches[0][lane]] + pressures[patches[1][lane]] + pressures[patches[2][lane]] +
                pressures[patches[3][lane]];
  return 0.25 * Lanes(sum);
}

// Six times the volume of a tetrahedron with these nodes (m³), negative where it is inside out.
inline Lanes edge_determinant(const NodalLanes& x) {
  Lanes e[3][3];
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 3; ++i) e[k][i] = x[k + 1][i] - x[0][i];
  return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

inline void load(const StrainBatch& batch, Lanes (&strain)[6]) {
  for (int k = 0; k < 6; ++k) strain[k] = batch.at[k];
}

inline Lanes remembering_forces(const TetrahedronShape<Octet>& shape, const NodalLanes& x, const MemoryArrays& memory,
                                std::size_t batch, Lanes (&q)[4], NodalLanes& force) {
  const std::size_t branches = memory.branches;
  Lanes kept[6];
  for (Lanes& strain : kept) strain = 0.0;
  for (std::size_t i = batch * branches; i < (batch + 1) * branches; ++i) {
    Lanes z[6];
    load(memory.crept[i], z);
    const Lanes given = memory.given[i];
    for (int k = 0; k < 6; ++k) kept[k] = kept[k] + given * z[k];
  }
  return acus::remembering_forces(shape, x, Lanes(memory.stiffening[batch]), kept, q, force);
}

bool elastic_forces(const ElementArrays& elements, const double* x, const RotationBatch* start,
                    RotationBatch* rotations, double* forces, double* volume_changes) {
  LaneMask upright = Lanes(0.0) <= Lanes(0.0);
  for (std::size_t b = 0; b < elements.count; ++b) {
    const ElementBatch& batch = elements.shapes[b];
    NodalLanes local, force;
    gather(batch, x, local);
    upright = upright & (edge_determinant(local) > 0.0);
    Lanes q[4];
    load(start[b], q);
    const Lanes strain = elements.memory == nullptr
                             ? corotational_forces(batch.shape, local, q, force)
                             : remembering_forces(batch.shape, local, *elements.memory, b, q, force);
    for (int i = 0; i < 4; ++i) q[i].store(rotations[b].q[i].at);
    if (elements.patches != nullptr)
      add_volume_change(elements.patches[b], batch.shape.volume * strain, volume_changes);
    add_to_nodes(batch, force, forces);
  }
  return all(upright);
}

void relax(const ElementArrays& elements, const double* x, const RotationBatch* rotations, const Octet* taken,
           StrainBatch* crept, double* forces) {
  const MemoryArrays& memory = *elements.memory;
  const std::size_t branches = memory.branches;
  for (std::size_t b = 0; b < elements.count; ++b) {
    const ElementBatch& batch = elements.shapes[b];
    NodalLanes local, force;
    gather(batch, x, local);
    Lanes q[4], r[3][3], strain[6], change[6];
    load(rotations[b], q);
    strain_of(batch.shape, local, q, r, strain);
    for (Lanes& entry : change) entry = 0.0;
    for (std::size_t i = b * branches; i < (b + 1) * branches; ++i) {
      Lanes z[6];
      load(memory.crept[i], z);
      const Lanes given = memory.given[i], share = taken[i];
      for (int k = 0; k < 6; ++k) {
        const Lanes step = share * (strain[k] - z[k]);
        change[k] = change[k] - given * step;
        (z[k] + step).store(crept[i].at[k].at);
      }
    }
    strain_forces(batch.shape, r, change, force);
    add_to_nodes(batch, force, forces);
  }
}

void damping_forces(const ElementArrays& elements, const double* v, const RotationBatch* rotations, double* forces,
                    double* volume_changes) {
  for (std::size_t b = 0; b < elements.count; ++b) {
    const ElementBatch& batch = elements.shapes[b];
    NodalLanes local, force;
    gather(batch, v, local);
    Lanes q[4];
    load(rotations[b], q);
    const Lanes rate = turned_stiffness_forces(batch.shape, local, q, force);
    for (auto& node : force)
      for (Lanes& component : node) component = component * elements.damping[b];
    if (elements.patches != nullptr) add_volume_change(elements.patches[b], batch.shape.volume * rate, volume_changes);
    add_to_nodes(batch, force, forces);
  }
}

void pressure_forces(const ElementArrays& elements, const double* pressures, const RotationBatch* rotations,
                     double* forces) {
  for (std::size_t b = 0; b < elements.count; ++b) {
    Lanes q[4];
    load(rotations[b], q);
    NodalLanes force;
    acus::pressure_forces(elements.shapes[b].shape, mean_pressure(elements.patches[b], pressures), q, force);
    add_to_nodes(elements.shapes[b], force, forces);
  }
}

inline void add_with_its_sign(double* total, const double* q) {
  const double dot = total[0] * q[0] + total[1] * q[1] + total[2] * q[2] + total[3] * q[3];
  for (int i = 0; i < 4; ++i) total[i] += dot < 0 ? -q[i] : q[i];
}

void add_rotations(const ElementArrays& elements, const RotationBatch* rotations, bool same_sign, double* sums) {
  for (std::size_t b = 0; b < elements.count; ++b) {
    const ElementBatch& batch = elements.shapes[b];
    Lanes q[4];
    load(rotations[b], q);
    for (Lanes& component : q) component = component * batch.shape.volume;
    Quad weighted[kLanes];
    transpose(q[0], q[1], q[2], q[3], weighted);
    for (int k = 0; k < 4; ++k)
      for (int lane = 0; lane < kLanes; ++lane) {
        double* node = sums + 4 * batch.nodes[k][lane];
        if (same_sign) {
          add_quad(node, weighted[lane]);
        } else {
          double one[4];
          __builtin_memcpy(one, &weighted[lane], sizeof one);
          add_with_its_sign(node, one);
        }
      }
  }
}

bool all_turned_less(const ElementArrays& elements, const RotationBatch* rotations, double least) {
  LaneMask less = Lanes(0.0) <= Lanes(0.0);
  for (std::size_t b = 0; b < elements.count; ++b) less = less & (Lanes(rotations[b].q[0]) > least);
  return all(less);
}

}  // namespace

extern const ElementKernel kernel_of_elements{elastic_forces,  relax,         damping_forces,
                                              pressure_forces, add_rotations, all_turned_less};

}  // namespace ACUS_KERNEL
}  // namespace acus
