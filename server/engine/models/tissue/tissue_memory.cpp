// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue_memory.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/models/element/corotational_energy.h"

namespace acus {

TissueMemory::TissueMemory(const TissueModel& model, double h) : branches(model.branches), least_stiffening(0) {
  const std::size_t tetrahedra = model.elements.size(), batches = model.batches.size();
  const auto n = static_cast<std::size_t>(branches);
  std::vector<RelaxationStep> steps;
  for (const Material& material : model.materials) steps.emplace_back(material, h);
  const auto step = [&](std::size_t t) -> const RelaxationStep& {
    return steps[static_cast<std::size_t>(model.material_of[t])];
  };
  for (std::size_t t = 0; t < tetrahedra; ++t) stiffening.push_back(step(t).stiffening);
  least_stiffening = stiffening.empty() ? 1 : *std::ranges::min_element(stiffening);
  batch_stiffening.resize(batches);
  given.resize(batches * n);
  taken.resize(batches * n);
  for (std::size_t b = 0; b < batches; ++b)
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const RelaxationStep& law = step(std::min(b * kLanes + lane, tetrahedra - 1));
      batch_stiffening[b].at[lane] = law.stiffening;
      for (std::size_t i = 0; i < n; ++i) {
        given[b * n + i].at[lane] = law.given[static_cast<Eigen::Index>(i)];
        taken[b * n + i].at[lane] = law.taken[static_cast<Eigen::Index>(i)];
      }
    }
}

void relax(const TissueModel& model, const TissueMemory& memory, const Matrix3X& x, const ElementRotations& rotations,
           const std::vector<StrainBatch>& before, std::vector<StrainBatch>& crept, ElementScratch& scratch,
           Matrix3X& forces) {
  assert(before.size() == memory.given.size() && crept.size() == before.size());
  const MemoryArrays arrays = memory.arrays(before);
  const ElementArrays elements{.count = model.batches.size(), .shapes = model.batches.data(), .memory = &arrays};
  scratch.x.topRows<3>() = x;
  scratch.forces.setZero();
  element_kernel().relax(elements, scratch.x.data(), rotations.batches.data(), memory.taken.data(), crept.data(),
                         scratch.forces.data());
  forces += scratch.forces.topRows<3>();
}

double memory_energy(const TissueModel& model, const TissueMemory& memory, const Matrix3X& x,
                     const ElementRotations& rotations, const std::vector<StrainBatch>& before) {
  const auto n = static_cast<std::size_t>(memory.branches);
  double energy = 0;
  for (std::size_t t = 0; t < model.elements.size(); ++t) {
    double local[4][3], q[4];
    gather_nodes(x, model.mesh->tetrahedra[t], local);
    rotations.element(static_cast<int>(t), q);
    const Matrix3 strain = corotational_strain(model.elements[t], local, q);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t at = t / kLanes * n + i, lane = t % kLanes;
      Matrix3 crept;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) crept(a, b) = before[at].at[kStrainPlace[a][b]].at[lane];
      const double left = 1 - memory.taken[at].at[lane];
      // g (1 - alpha) times (1 - alpha)
      energy += memory.given[at].at[lane] * left * strain_energy(model.elements[t], strain - crept);
    }
  }
  return energy;
}

}  // namespace acus
