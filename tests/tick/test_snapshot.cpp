// SPDX-License-Identifier: GPL-3.0-or-later
// Snapshots: another simulation of the same scene goes on bit by bit, and whatever else comes as one is refused, or at least
// does no harm. test_state.cpp goes through all scenes.
#include <doctest/doctest.h>
#include <xxhash.h>

#include <cstring>
#include <limits>

#include "server/engine/math/random.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr std::size_t kHeader = 32, kChecksum = 8;

// In the middle of an insertion, with a path that was left.
Scene two_needles() {
  Scene scene = block_scene();
  scene.needles = {needle_at({0.003, 0.002, 0.03}, 0.005), needle_at({-0.013, 0.002, 0.03}, 0.005)};
  scene.needles[1].name = "second";
  return scene;
}

class Inserted {
 public:
  explicit Inserted(const Scene& scene) : bench(scene) {
    bench.push(0, 0.020, 0.05);
    bench.push(1, 0.015, 0.05);
    bench.push(1, -0.020, 0.05);
  }
  const Model& model() const { return bench.simulation().model(); }
  std::vector<std::byte> snapshot() const { return make_snapshot(model().fingerprint, bench.simulation().state()); }

  Bench bench;
};

std::string refusal(const Model& model, std::span<const std::byte> bytes) {
  try {
    read_snapshot(model, bytes);
    return "";
  } catch (const SnapshotError& error) {
    return error.what();
  }
}

void seal(std::vector<std::byte>& snapshot) {
  const std::uint64_t sum = XXH3_64bits(snapshot.data(), snapshot.size() - kChecksum);
  std::memcpy(snapshot.data() + snapshot.size() - kChecksum, &sum, sizeof sum);
}

}  // namespace

TEST_CASE("another simulation goes on from a snapshot bit by bit") {
  const Inserted first(two_needles());
  Simulation one(two_needles()), other(two_needles());
  one.restore(first.bench.simulation().state());
  other.restore(read_snapshot(other.model(), first.snapshot()));
  for (int i = 0; i < 200; ++i) {
    one.step();
    other.step();
    REQUIRE(hash(one.state()) == hash(other.state()));
  }
}

TEST_CASE("a snapshot that is damaged, foreign or no snapshot is refused with the reason") {
  const Inserted run(two_needles());
  const std::vector<std::byte> good = run.snapshot();
  CHECK(refusal(run.model(), good).empty());
  CHECK(refusal(run.model(), {}) == "this is no snapshot of Acus");
  for (const std::size_t size : {std::size_t{1}, kHeader, kHeader + kChecksum, good.size() / 2, good.size() - 1}) {
    CAPTURE(size);
    CHECK_FALSE(refusal(run.model(), std::span(good).first(size)).empty());
  }
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::byte> damaged = good;
    damaged[static_cast<std::size_t>(random.index(static_cast<int>(good.size())))] ^= std::byte{1};
    CHECK_FALSE(refusal(run.model(), damaged).empty());
  }
  std::vector<std::byte> of_other_version = good;
  of_other_version[8] ^= std::byte{1};
  seal(of_other_version);
  CHECK(refusal(run.model(), of_other_version).find("another version") != std::string::npos);
}

TEST_CASE("a snapshot is that of one scene: other rates, materials, needles and meshes have other fingerprints") {
  const Inserted run(two_needles());
  const std::vector<std::byte> good = run.snapshot();
  const auto refused = [&](auto change) {
    Scene scene = two_needles();
    change(scene);
    const Simulation other(scene);
    return refusal(other.model(), good).find("another scene") != std::string::npos;
  };
  CHECK(refused([](Scene& s) { s.rate = 501; }));
  CHECK(refused([](Scene& s) { s.tissue.regions[0].material.young_modulus *= 1 + 1e-15; }));
  CHECK(refused([](Scene& s) { s.tissue.regions[0].interaction.friction_contact = 0.1; }));
  CHECK(refused([](Scene& s) { s.needles[1].smoothing = 0.01; }));
  CHECK(refused([](Scene& s) { s.tissue.box.size.z() *= 1.01; }));
  CHECK(refused([](Scene& s) { s.tissue.fixed.pop_back(); }));
  CHECK_FALSE(refused([](Scene& s) { s.name = "the same by another name"; }));
  CHECK_FALSE(refused([](Scene& s) { s.publish.tissue_rate = 1; }));
}

// A checksum is soon made: what a hostile client writes into the image must not crash the tick.
TEST_CASE("a state whose indices lead nowhere is refused") {
  const Inserted run(two_needles());
  constexpr int kMost = std::numeric_limits<int>::max(), kLeast = std::numeric_limits<int>::min();
  const auto refused = [&](auto forge) {
    State state = run.bench.simulation().state();
    forge(state);
    return !refusal(run.model(), make_snapshot(run.model().fingerprint, state)).empty();
  };
  CHECK_FALSE(refused([](State&) {}));
  REQUIRE_FALSE(run.bench.simulation().state().paths[0].empty());
  for (const int wrong : {kLeast, -2, kMost, kMost - 1, 1 << 20}) {
    CAPTURE(wrong);
    CHECK(refused([&](State& s) { s.paths[0].needle = wrong; }));
    CHECK(refused([&](State& s) { s.paths[63].needle = wrong; }));
    CHECK(refused([&](State& s) { s.paths[0].end.tetrahedron = wrong; }));
    CHECK(refused([&](State& s) { s.paths[0].vertices[0].tetrahedron = wrong; }));
    CHECK(refused([&](State& s) { s.paths[0].exits.push_back(wrong); }));
    CHECK(refused([&](State& s) { s.insertions[0].path = wrong; }));
    CHECK(refused([&](State& s) { s.insertions[0].border = wrong; }));
    CHECK(refused([&](State& s) { s.insertions[0].touched.tetrahedron = wrong; }));
    CHECK(refused([&](State& s) { s.insertions[0].first_alongside = wrong; }));
    CHECK(refused([&](State& s) { s.insertions[0].last_alongside = wrong; }));
    CHECK(refused([&](State& s) { s.monitors[0].next = wrong; }));
  }
  CHECK(refused([](State& s) { s.paths[1].exits.push_back(1); }));  // one that was left
  CHECK(refused([](State& s) { s.insertions[0].phase = static_cast<Phase>(77); }));
  CHECK(refused([](State& s) { s.insertions[0].phase = Phase::free; }));
  CHECK(refused([](State& s) { s.insertions[1].phase = Phase::inside; }));
  CHECK(refused([](State& s) { s.insertions[1].phase = Phase::contact; }));
  CHECK(refused([](State& s) { s.tissue.x(0, 0) = std::numeric_limits<double>::quiet_NaN(); }));
  CHECK(refused([](State& s) { s.tissue.v(0, 0) = 1e300; }));
  CHECK(refused([](State& s) { s.needles[0].q[1].coeffs().setZero(); }));
  CHECK(refused([](State& s) { s.bases[0].target.orientation.coeffs().setZero(); }));
  CHECK(refused([](State& s) { s.bases[0].command_tick = s.tick + 1; }));
  CHECK(refused([](State& s) {
    for (auto& q : s.tissue.rotations.batches[0].q) q = Octet{};
  }));
}

TEST_CASE("a snapshot whose forces and places no tissue can have is refused") {
  const Inserted run(two_needles());
  const State& good = run.bench.simulation().state();
  const auto refused = [&](auto forge) {
    State state = good;
    forge(state);
    return !refusal(run.model(), make_snapshot(run.model().fingerprint, state)).empty();
  };
  constexpr double kMuch = 1e12;
  CHECK(!refused([](State&) {}));
  CHECK(refused([](State& s) { s.tissue.x(1, 5) = kMuch; }));
  CHECK(refused([](State& s) { s.tissue.v(1, 5) = kMuch; }));
  CHECK(refused([](State& s) { s.insertions[0].tip.contact.along = kMuch; }));
  CHECK(refused([](State& s) { s.insertions[0].tip.cut.along = kMuch; }));
  CHECK(refused([](State& s) { s.insertions[0].tip.cut.creep.along[0] = kMuch; }));
  CHECK(refused([](State& s) { s.insertions[0].tip.contact.across[0] = -kMuch; }));
  CHECK(refused([](State& s) { s.insertions[0].vertices[1].contact.along = kMuch; }));
  CHECK(refused([](State& s) { s.insertions[0].vertices[1].contact.torsion = kMuch; }));
  CHECK(refused([](State& s) { s.insertions[0].vertices[1].contact.across[2] = kMuch; }));
  CHECK(refused([](State& s) { s.insertions[0].cells[1].contact.across[2] = kMuch; }));
}

TEST_CASE("a forged image is refused, or does no harm" * doctest::test_suite("gate")) {
  const Inserted run(two_needles());
  const std::vector<std::byte> good = run.snapshot();
  Simulation simulation(two_needles());
  Random random(11);
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<std::byte> forged = good;
    const int changes = 1 + random.index(4);
    for (int k = 0; k < changes; ++k) {
      // Half of them behind the tissue, where indices are.
      const std::size_t body = good.size() - kHeader - kChecksum, part = i % 2 == 0 ? body : body / 3;
      const std::size_t at = good.size() - kChecksum - 1 - static_cast<std::size_t>(random.index(static_cast<int>(part)));
      forged[at] = static_cast<std::byte>(random.index(256));
    }
    seal(forged);
    try {
      simulation.restore(read_snapshot(simulation.model(), forged));
    } catch (const SnapshotError&) {
      ++refused;
      continue;
    }
    for (int tick = 0; tick < 5; ++tick) simulation.step();
  }
  CHECK(refused > 0);
  simulation.reset();
  simulation.step();
  CHECK((simulation.report().flags & kNotFinite) == 0);
}

}  // namespace acus::test
