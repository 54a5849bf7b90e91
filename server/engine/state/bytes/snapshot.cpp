// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/bytes/snapshot.h"

#include <bit>
#include <cstring>

#include "server/engine/math/hasher.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "server/engine/state/bytes/state_check.h"

namespace acus {

namespace {

static_assert(std::endian::native == std::endian::little, "snapshots are little-endian");

// Raised whenever a tick makes something else of the same state.
constexpr std::uint64_t kPhysics = 4;

constexpr char kMagic[8] = {'a', 'c', 'u', 's', 's', 'n', 'a', 'p'};

struct Header {
  char magic[8];
  std::uint64_t version, fingerprint, size;
};
static_assert(sizeof(Header) == 32);

using Checksum = std::uint64_t;

Checksum checksum(std::span<const std::byte> bytes) {
  Hasher hasher;
  hasher.bytes(bytes.data(), bytes.size());
  return hasher.digest();
}

}  // namespace

std::vector<std::byte> make_snapshot(std::uint64_t fingerprint, const State& state) {
  const std::vector<std::byte> image = to_bytes(state);
  Header header{{}, state_layout() + kPhysics, fingerprint, image.size()};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  std::vector<std::byte> snapshot(sizeof header + image.size() + sizeof(Checksum));
  std::memcpy(snapshot.data(), &header, sizeof header);
  std::memcpy(snapshot.data() + sizeof header, image.data(), image.size());
  const Checksum sum = checksum(std::span(snapshot).first(sizeof header + image.size()));
  std::memcpy(snapshot.data() + sizeof header + image.size(), &sum, sizeof sum);
  return snapshot;
}

State read_snapshot(const Model& model, std::span<const std::byte> snapshot) {
  constexpr std::size_t kAround = sizeof(Header) + sizeof(Checksum);
  Header header;
  if (snapshot.size() >= sizeof header) std::memcpy(&header, snapshot.data(), sizeof header);
  if (snapshot.size() < kAround || std::memcmp(header.magic, kMagic, sizeof kMagic) != 0)
    throw SnapshotError("this is no snapshot of Acus");
  Checksum sum = 0;
  std::memcpy(&sum, snapshot.data() + snapshot.size() - sizeof sum, sizeof sum);
  if (header.size != snapshot.size() - kAround || sum != checksum(snapshot.first(snapshot.size() - sizeof sum)))
    throw SnapshotError("the snapshot is damaged: its checksum is another one");
  if (header.version != state_layout() + kPhysics)
    throw SnapshotError("the snapshot was taken by another version of Acus; take it again with this one");
  if (header.fingerprint != model.fingerprint)
    throw SnapshotError("the snapshot is of another scene, or the scene, its mesh or the rate was changed since");
  State state = make_state(model);
  try {
    from_bytes(snapshot.subspan(sizeof header, header.size), state);
    check_state(model, state);
    state.economizing = false;  // the run that continues decides what is reduced
  } catch (const std::runtime_error& error) {
    throw SnapshotError(std::string("the snapshot cannot be used: ") + error.what());
  }
  return state;
}

bool begins_as_snapshot(std::string_view beginning) {
  return beginning.starts_with(std::string_view(kMagic, sizeof kMagic));
}

}  // namespace acus
