// SPDX-License-Identifier: GPL-3.0-or-later
// The kernels of every instruction set that this processor has compute the same bits.
#include "server/engine/math/kernel_set.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "server/engine/math/factor/panel_kernel.h"
#include "server/engine/math/lanes.h"
#include "server/engine/math/random.h"
#include "server/engine/models/element/element_kernel.h"
#include "tests/support/kernel_sets.h"

namespace acus {
namespace {

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), sizeof(T) * a.size()) == 0;
}

std::vector<double> numbers(Random& random, int count) {
  std::vector<double> list;
  for (int i = 0; i < count; ++i) list.push_back(random.uniform(-1, 1));
  return list;
}

template <class Real>
Real rounded_to(double number) {
  if constexpr (std::is_same_v<Real, Float16>) {
    return {static_cast<unsigned short>((std::bit_cast<std::uint32_t>(static_cast<float>(number)) >> 13) & 0xbfff)};
  } else {
    return static_cast<Real>(number);
  }
}

// The strips of a panel, of random numbers.
template <class Real>
std::vector<Real> random_panel(Random& random, int columns, int below) {
  int size = 0;
  for (int j = 0; j < columns; j += kStripColumns) {
    const int width = std::min(kStripColumns, columns - j);
    size += strip_size(width, columns - j - width + below);
  }
  std::vector<Real> panel;
  for (const double number : numbers(random, size)) panel.push_back(rounded_to<Real>(number));
  return panel;
}

template <class Real>
void check_panels() {
  Random random(1);
  for (const int columns : {1, 2, 3, 4, 5, 6, 7, 12, 27})
    for (const int below : {0, 1, 7, 8, 9, 50}) {
      CAPTURE(columns);
      CAPTURE(below);
      const std::vector<Real> panel = random_panel<Real>(random, columns, below);
      const int rows = columns + below + kTileRows;
      const std::vector<double> right_sides = numbers(random, 3 * rows);
      const auto substituted = [&] {
        const PanelKernel<Real>& kernel = panel_kernel<Real>();
        std::vector<double> one = right_sides, three = right_sides, back = right_sides;
        kernel.forward_one(panel.data(), columns, below, {0.5, 0.25}, one.data());
        kernel.forward_three(panel.data(), columns, below, {0.5, 0.25}, three.data(), rows);
        kernel.backward(panel.data() + panel.size(), columns, below, {0.5, 0.25}, back.data());
        one.insert(one.end(), three.begin(), three.end());
        one.insert(one.end(), back.begin(), back.end());
        return one;
      };
      const auto [narrow, wide] = test::with_both_sets(substituted);
      CHECK(same_bits(narrow, wide));
    }
}

TEST_CASE("substitutions with panels give the same bits with wide registers") {
  if (test::only_one_set()) return;
  check_panels<float>();
  check_panels<double>();
  check_panels<Float16>();
}

// Tetrahedra at random places, in any state from unturned to inside out.
TEST_CASE("forces, rotations and volumes of elements give the same bits with wide registers") {
  if (test::only_one_set()) return;
  constexpr int kNodes = 40, kPatches = 10, kBatches = 25;
  Random random(2);
  std::vector<ElementBatch> shapes(kBatches);
  std::vector<Octet> damping(kBatches);
  std::vector<PatchBatch> patches(kBatches);
  std::vector<RotationBatch> start(kBatches);
  for (int b = 0; b < kBatches; ++b)
    for (int lane = 0; lane < kLanes; ++lane) {
      for (int i = 0; i < 9; ++i) shapes[b].shape.gradient[i / 3][i % 3][lane] = random.uniform(-100, 100);
      shapes[b].shape.volume[lane] = lane == 7 && b % 4 == 0 ? 0 : random.uniform(1e-9, 1e-7);
      shapes[b].shape.law.mu[lane] = random.uniform(1e2, 1e6);
      shapes[b].shape.law.lambda[lane] = random.uniform(1e2, 1e6);
      damping[b][lane] = random.uniform(0, 0.1);
      double size = 0;
      for (int i = 0; i < 4; ++i) {
        shapes[b].nodes[i][lane] = random.index(kNodes);
        patches[b].patches[i][lane] = random.index(kPatches);
        start[b].q[i][lane] = random.uniform(-1, 1);
        size += start[b].q[i][lane] * start[b].q[i][lane];
      }
      for (int i = 0; i < 4; ++i) start[b].q[i][lane] /= std::sqrt(size);
    }
  const std::vector<double> x = numbers(random, 4 * kNodes), pressures = numbers(random, kPatches);
  constexpr int kBranches = 2;
  std::vector<Octet> stiffening(kBatches), given(kBranches * kBatches), taken(kBranches * kBatches);
  std::vector<StrainBatch> crept(kBranches * kBatches);
  for (std::vector<Octet>* octets : {&stiffening, &given, &taken})
    for (Octet& octet : *octets)
      for (double& number : octet.at) number = random.uniform(0.1, 0.9);
  for (StrainBatch& batch : crept)
    for (Octet& octet : batch.at)
      for (double& number : octet.at) number = random.uniform(-0.1, 0.1);
  const MemoryArrays memory{kBranches, stiffening.data(), given.data(), crept.data()};
  for (const bool has_patches : {false, true}) {
    const ElementArrays elements{kBatches, shapes.data(), damping.data(), has_patches ? patches.data() : nullptr,
                                 has_patches ? &memory : nullptr};
    const auto computed = [&] {
      const ElementKernel& kernel = element_kernel();
      std::vector<RotationBatch> rotations(kBatches);
      std::vector<double> forces(4 * kNodes), volumes(kPatches), sums(4 * kNodes);
      const bool upright =
          kernel.elastic_forces(elements, x.data(), start.data(), rotations.data(), forces.data(), volumes.data());
      kernel.damping_forces(elements, x.data(), rotations.data(), forces.data(), volumes.data());
      if (has_patches) kernel.pressure_forces(elements, pressures.data(), rotations.data(), forces.data());
      kernel.add_rotations(elements, rotations.data(), false, sums.data());
      kernel.add_rotations(elements, rotations.data(), true, sums.data());
      std::vector<StrainBatch> after(crept.size());
      if (has_patches) kernel.relax(elements, x.data(), rotations.data(), taken.data(), after.data(), forces.data());
      std::vector<double> all = forces;
      for (const StrainBatch& batch : after)
        for (const Octet& strain : batch.at) all.insert(all.end(), strain.at, strain.at + kLanes);
      all.insert(all.end(), volumes.begin(), volumes.end());
      all.insert(all.end(), sums.begin(), sums.end());
      for (const RotationBatch& batch : rotations)
        for (const Octet& q : batch.q) all.insert(all.end(), q.at, q.at + kLanes);
      all.push_back(upright);
      all.push_back(kernel.all_turned_less(elements, rotations.data(), 0.7));
      all.push_back(kernel.all_turned_less(elements, rotations.data(), -1.1));
      return all;
    };
    const auto [narrow, wide] = test::with_both_sets(computed);
    CHECK(same_bits(narrow, wide));
  }
}

TEST_CASE("the narrow kernels can always be used, and each set has a name of its own") {
  CHECK(can_use(KernelSet::baseline));
  if (can_use(KernelSet::v4)) CHECK(std::string(name_of(KernelSet::baseline)) != name_of(KernelSet::v4));
  CHECK(can_use(kernel_set()));
}

}  // namespace
}  // namespace acus
