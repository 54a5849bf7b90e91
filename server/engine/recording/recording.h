// SPDX-License-Identifier: GPL-3.0-or-later
// What a recording says: all that a simulation was told, tick by tick, and hashes of what came of it. From that the
// same program makes the same ticks again, to the last bit.
//
// A recording is a file of zstd frames, each whole in itself, two a second; unpacked (zstd -dc) they are one sequence
// of msgpack arrays, the first element of each a name:
//
//   "recording", version, server, started      first of all; the server's version; UTC, ISO 8601
//   "scene", file, text, rate, fingerprint, mesh   which the next "begin" is of; rate (Hz) replaces the text's; mesh:
//   nil,
//                                              or what the scene's mesh file held, [nodes, tetrahedra, groups, names]
//   "begin", epoch, snapshot                   the state from which all that follows continues (state/bytes/snapshot.h)
//   "command", body, seq, pose, spin           for the next tick; pose: [x, y, z, w, x, y, z] or nil; spin: or nil
//   "tick", tick, digest, economizing          made; digest: XXH3 of its report
//   "state", tick, hash                        of the whole state after that tick (state/bytes/state_bytes.h)
//   "end", why                                 the last; "" if somebody asked for it
//
// Lengths are in metres, angles in radians. Nodes are float64, 3 each; tetrahedra int32, 4 each; groups int32,
// little-endian.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "server/engine/math/hasher.h"
#include "server/engine/tick/simulation.h"

namespace acus {

// A recording that cannot be written or used; what() is a sentence.
struct RecordingError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

namespace recorded {

struct Opening {
  std::uint64_t version = 1;
  std::string server;
  std::string started;
};
struct World {
  std::string file, text;
  double rate = 0;  // Hz
  std::uint64_t fingerprint = 0;
  std::optional<TetrahedralMesh> own_mesh;  // nodes, tetrahedra, tags and their names; without topology
};
struct Beginning {
  std::uint64_t epoch = 0;
  std::vector<std::byte> snapshot;
};
struct BodyCommand {
  int body = 0;  // of the needles in the order of the scene, then of the guides
  Command command;
};
struct Tick {
  std::uint64_t tick = 0;
  std::uint64_t digest = 0;
  bool economizing = false;
};
struct StateAfter {
  std::uint64_t tick = 0;
  std::uint64_t hash = 0;  // comparable_hash()
};
struct Ending {
  std::string why;
};
using Item = std::variant<Opening, World, Beginning, BodyCommand, Tick, StateAfter, Ending>;

}  // namespace recorded

// Of a recording that begins now; `server`: the version of Acus.
recorded::Opening opening_now(const std::string& server);

// Of a scene as it was loaded; `own_mesh` as read_mesh() gave it.
recorded::World record_of(const Scene& scene, const TetrahedralMesh& own_mesh, std::uint64_t fingerprint);

// The scene again, and what its mesh file held, with topology; nothing where it names no file. Throws SceneError,
// RecordingError.
struct RecordedScene {
  Scene scene;
  std::optional<TetrahedralMesh> own_mesh;
};
RecordedScene scene_of(const recorded::World& world);

// The scene again, and a simulation of it; throws SceneError, and RecordingError if it is another one than was recorded.
std::unique_ptr<Simulation> simulation_of(const recorded::World& world, const Progress& progress = {});

void append(std::string& bytes, const recorded::Item& item);

// The item at the beginning of `bytes`, which then begins behind it. Throws RecordingError.
recorded::Item take_item(std::string_view& bytes);

// Of what a tick told. Takes no memory: `hasher` is there to be used again.
std::uint64_t digest(Hasher& hasher, const TickReport& report);

}  // namespace acus
