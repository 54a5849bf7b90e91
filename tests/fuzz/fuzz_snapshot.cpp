// SPDX-License-Identifier: GPL-3.0-or-later
// Images of states with a header and a checksum that are right: what is accepted is a state that ticks can go on from.
#include <cstring>

#include "server/engine/math/hasher.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/pushing.h"
#include "tests/support/small_block.h"

namespace {

// Header and image of a snapshot, and its checksum after them.
constexpr std::size_t kHeader = 32, kChecksum = 8;

std::vector<std::byte> snapshot_of(std::vector<std::byte> snapshot, const std::uint8_t* data, std::size_t size) {
  snapshot.resize(kHeader);
  const std::uint64_t image = size;
  std::memcpy(snapshot.data() + kHeader - sizeof image, &image, sizeof image);
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  snapshot.insert(snapshot.end(), bytes, bytes + size);
  acus::Hasher hasher;
  hasher.bytes(snapshot.data(), snapshot.size());
  const std::uint64_t checksum = hasher.digest();
  snapshot.resize(snapshot.size() + kChecksum);
  std::memcpy(snapshot.data() + snapshot.size() - kChecksum, &checksum, kChecksum);
  return snapshot;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static acus::Simulation simulation(acus::test::small_block());
  static const std::vector<std::byte> whole = make_snapshot(simulation.model().fingerprint, simulation.state());
  try {
    simulation.restore(read_snapshot(simulation.model(), snapshot_of(whole, data, size)));
    for (int i = 0; i < 3; ++i) acus::fuzz::push(simulation);
    const acus::TickReport& report = simulation.report();
    acus::fuzz::require(report.needles[0].tip_position.allFinite(), "a tip is somewhere");
  } catch (const acus::SnapshotError&) {
  }
  return 0;
}
