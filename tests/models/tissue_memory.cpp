// SPDX-License-Identifier: GPL-3.0-or-later
// What tissue remembers, against the closed forms of the Prony series.
#include "server/engine/models/tissue/tissue_memory.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "server/engine/math/random.h"
#include "tests/models/bench_tissue.h"
#include "tests/models/motions.h"

namespace acus {
namespace {

constexpr double kHalf = 0.05;
constexpr Relaxation kFast{.ratio = 0.6, .time = 0.3}, kSlow{.ratio = 0.4, .time = 5};

Material remembering() {
  Material material = undamped_material();
  material.relaxation = {kFast, kSlow};
  return material;
}

double prony(double t) { return 1 + kFast.ratio * std::exp(-t / kFast.time) + kSlow.ratio * std::exp(-t / kSlow.time); }

// Elements alone, tick by tick.
struct Elements {
  explicit Elements(const TissueModel& m, double h) : model(m), memory(m, h), rotations(m), scratch(m) {
    crept = *make_tissue_state(m).crept;
  }

  // Forces at x at the end of a tick that ends there.
  Matrix3X tick(const Matrix3X& x) {
    const MemoryArrays arrays = memory.arrays(crept);
    Matrix3X forces(3, model.nodes());
    elastic_forces(model, x, rotations, rotations, scratch, forces, &arrays);
    energy = elastic_energy(model, x, rotations) + memory_energy(model, memory, x, rotations, crept);
    std::vector<StrainBatch> after(crept.size());
    Matrix3X changed = forces;
    relax(model, memory, x, rotations, crept, after, scratch, changed);
    crept.swap(after);
    return forces;
  }

  const TissueModel& model;
  TissueMemory memory;
  ElementRotations rotations;
  ElementScratch scratch;
  std::vector<StrainBatch> crept;
  double energy = 0;
};

struct Block {
  explicit Block(TissueElement element = TissueElement::linear)
      : mesh(make_box_mesh(Vector3::Constant(2 * kHalf), {3, 3, 3})),
        model(bench_tissue(mesh, remembering(), nullptr, Vector3::Zero(), element)) {}

  Matrix3X hooke(const Matrix3X& x) const {
    Matrix3X forces;
    rotations_at(model, x, forces);
    return forces;
  }

  TetrahedralMesh mesh;
  TissueModel model;
};

}  // namespace

TEST_CASE("a strain that is held gives the forces of the Prony series, at any tick") {
  const Block block;
  const Matrix3X x = (Matrix3::Identity() + Random(1).matrix(3, 3, 0.05)) * block.mesh.nodes;
  const Matrix3X rest = block.hooke(x);
  for (const double h : {1e-3, 0.02, 0.5}) {
    Elements elements(block.model, h);
    CAPTURE(h);
    for (double t = h; t < 3; t += h) CHECK((elements.tick(x) - prony(t) * rest).norm() < 1e-9 * rest.norm());
  }
}

TEST_CASE("what is strained and turned feels forces that turn along, and turning alone relaxes nothing") {
  const Block block;
  const double h = 0.01;
  Elements still(block.model, h), turning(block.model, h), rigid(block.model, h);
  const Matrix3X strained = (Matrix3::Identity() + Random(2).matrix(3, 3, 0.03)) * block.mesh.nodes;
  for (int i = 1; i <= 100; ++i) {
    const Matrix3 turn = rotation_exp({0.02 * i, 0.01 * i, -0.01 * i}).toRotationMatrix();
    const Matrix3X forces = still.tick(strained);
    CHECK((turning.tick(turn * strained) - turn * forces).norm() < 1e-9 * forces.norm());
    CHECK(rigid.tick(turn * block.mesh.nodes).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("a cycle has the storage and loss moduli of the Prony series") {
  const Block block;
  const double h = 1e-3, omega = 2 * std::numbers::pi / 0.8, amplitude = 1e-4;
  Elements elements(block.model, h);
  const Matrix3X stretch = Vector3(-0.4, -0.4, 1).asDiagonal() * block.mesh.nodes;
  const double stiffness = block.hooke(block.mesh.nodes + amplitude * stretch).cwiseProduct(stretch).sum() / amplitude;
  double storage = 1, loss = 0;
  for (const Relaxation& branch : {kFast, kSlow}) {
    const double x = omega * branch.time;
    storage += branch.ratio * x * x / (1 + x * x);
    loss += branch.ratio * x / (1 + x * x);
  }
  double in_phase = 0, out_of_phase = 0, gained = 0, before = 0, last_energy = 0;
  Matrix3X last_forces = Matrix3X::Zero(3, block.mesh.node_count());
  const int cycle = static_cast<int>(std::lround(0.8 / h));
  for (int i = 1; i <= 40 * cycle; ++i) {
    const double strain = amplitude * std::sin(omega * i * h);
    const Matrix3X forces = elements.tick(block.mesh.nodes + strain * stretch);
    // Work done on the elements, at the force of the tick's end, is never less than what they gain.
    const double work = (strain - before) * forces.cwiseProduct(stretch).sum();
    gained = std::max(gained, elements.energy - last_energy - work);
    before = strain, last_energy = elements.energy;
    if (i <= 39 * cycle) continue;
    const double force = forces.cwiseProduct(stretch).sum() / (stiffness * amplitude) * 2 / cycle;
    in_phase += force * std::sin(omega * i * h);
    out_of_phase += force * std::cos(omega * i * h);
  }
  CHECK(in_phase == doctest::Approx(storage).epsilon(2e-3).scale(0));
  CHECK(out_of_phase == doctest::Approx(loss).epsilon(1e-2).scale(0));
  CHECK(gained < 1e-9 * stiffness * amplitude * amplitude);
}

TEST_CASE("relaxing changes the forces by what the elastic forces at the same place change") {
  for (const TissueElement element : {TissueElement::linear, TissueElement::nodal_pressure}) {
    const Block block(element);
    Elements elements(block.model, 0.05);
    Random random(3);
    Matrix3X x = block.mesh.nodes;
    for (int i = 0; i < 5; ++i) {
      x += 1e-3 * random.matrix(3, block.mesh.node_count());
      elements.tick(x);
    }
    const MemoryArrays arrays = elements.memory.arrays(elements.crept);
    Matrix3X forces(3, block.mesh.node_count()), expected = forces;
    elastic_forces(block.model, x, elements.rotations, elements.rotations, elements.scratch, forces, &arrays);
    std::vector<StrainBatch> after(elements.crept.size());
    relax(block.model, elements.memory, x, elements.rotations, elements.crept, after, elements.scratch, forces);
    const MemoryArrays then = elements.memory.arrays(after);
    elastic_forces(block.model, x, elements.rotations, elements.rotations, elements.scratch, expected, &then);
    CHECK((forces - expected).norm() < 1e-12 * expected.norm());
  }
}

TEST_CASE("a block that is stretched and held relaxes as the Prony series") {
  const TetrahedralMesh mesh = make_box_mesh(Vector3::Constant(2 * kHalf), {3, 3, 3});
  Material material = remembering();
  material.density = 1;  // no waves
  const auto at_ends = [](const Vector3& p) { return std::abs(p.z()) > kHalf - 1e-9; };
  const TissueModel model = bench_tissue(mesh, material, at_ends);
  const double h = 5e-3;
  const auto pulled = [&](const TissueModel& m, double seconds) {
    TissueState state = make_tissue_state(m);
    BenchMotion motion(m, h, TissueMatrix::turned, 1, 1);
    for (const int i : m.fixed_nodes) state.x(2, i) *= 1.05;
    double force = 0;
    for (double t = 0; t < seconds - h / 2; t += h) {
      motion.begin(state);
      for (int k = 0; k < 20; ++k) {
        motion.linearize(state);
        motion.correct({});
      }
      motion.commit(state);
      state.v.setZero();
    }
    std::optional<TissueMemory> memory;
    std::optional<MemoryArrays> arrays;
    if (m.branches > 0) arrays = memory.emplace(m, h).arrays(*state.crept);
    Matrix3X forces(3, m.nodes());
    ElementScratch scratch(m);
    elastic_forces(m, state.x, state.rotations, state.rotations, scratch, forces, arrays ? &*arrays : nullptr);
    for (const int i : m.fixed_nodes)
      if (state.x(2, i) > 0) force += forces(2, i);
    return force;
  };
  Material hooke = material;
  hooke.relaxation.clear();
  const TissueModel without = bench_tissue(mesh, hooke, at_ends);
  const double rest = pulled(without, 0.5);
  for (const double t : {0.05, 0.3, 1.0, 3.0})
    CHECK(pulled(model, t) == doctest::Approx(prony(t) * rest).epsilon(5e-3).scale(0));
}

}  // namespace acus
