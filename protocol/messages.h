// SPDX-License-Identifier: MIT
// The messages between clients and the server, one plain struct each; protocol/README.md is the contract they follow.
// SI units, world frame unless a name says otherwise. Each struct lists its fields once, in fields(self, visit), which
// calls visit(name, member) for each; encoding, decoding, printing and tests all walk that list. An std::optional
// member is a field that may be absent, a vector of numbers travels as packed little-endian bytes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "protocol/enums.h"

namespace acus::protocol {

inline constexpr int kVersion = 2;        // the newest that is spoken here
inline constexpr int kOldestVersion = 2;  // and the oldest

inline constexpr const char* kDefaultCommandsEndpoint = "tcp://127.0.0.1:5750";
inline constexpr const char* kDefaultStatesEndpoint = "tcp://127.0.0.1:5751";

inline constexpr std::size_t kMaxCommandBytes = std::size_t{1} << 20;  // 1 MiB, of one message to the server
inline constexpr std::size_t kMaxRestoreBytes = std::size_t{31} << 20;  // 31 MiB, of `restore`
inline constexpr std::size_t kMaxStateBytes = std::size_t{1} << 30;    // 1 GiB, of one message to a client
inline constexpr std::uint32_t kMaxStepTicks = 100000;                 // of one `step` request

using Vector3 = std::array<double, 3>;  // x, y, z

struct Quaternion {  // unit; travels as the array [w, x, y, z]
  double w = 1, x = 0, y = 0, z = 0;
  bool operator==(const Quaternion&) const = default;
};

// ---- Requests: client to server on the commands socket, each answered once ----

// A request that carries nothing but its number: the client's choice, repeated in the answer.
struct BareRequest {
  std::uint64_t seq = 0;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
  }
};

// Answered by HelloReply, in the newest version that both sides speak. Its own `v` is the newest one of the client.
struct Hello {
  static constexpr const char* kType = "hello";
  std::uint64_t seq = 0;
  std::optional<std::uint32_t> oldest_version{};  // that the client speaks; absent: its newest

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("oldest_version", self.oldest_version);
  }
};
struct Describe : BareRequest {  // answered by DescribeReply
  static constexpr const char* kType = "describe";
};
struct Hash : BareRequest {  // answered by HashReply
  static constexpr const char* kType = "hash";
};
struct Snapshot : BareRequest {  // answered by SnapshotReply
  static constexpr const char* kType = "snapshot";
};
struct Pause : BareRequest {  // this one and all below: answered by Done
  static constexpr const char* kType = "pause";
};
struct Resume : BareRequest {
  static constexpr const char* kType = "resume";
};
struct Reset : BareRequest {
  static constexpr const char* kType = "reset";
};
struct Shutdown : BareRequest {
  static constexpr const char* kType = "shutdown";
};

// A request about needles and guides, by name; answered by Holding.
struct HoldRequest {
  std::uint64_t seq = 0;
  std::vector<std::string> needles;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("needles", self.needles);
  }
};

// Makes the client the one that commands them: all of them, or none if one is another's.
struct Acquire : HoldRequest {
  static constexpr const char* kType = "acquire";
};
// Gives back those of them that the client holds. A client that disconnects releases all it holds.
struct Release : HoldRequest {
  static constexpr const char* kType = "release";
};

struct Load {
  static constexpr const char* kType = "load";
  std::uint64_t seq = 0;
  std::optional<std::string> scene;  // path on the server's machine, or
  std::optional<std::string> text;   // the scene itself, YAML

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("scene", self.scene);
    visit("text", self.text);
  }
};

// Begins a recording, between two ticks, or ends it.
struct Record {
  static constexpr const char* kType = "record";
  std::uint64_t seq = 0;
  std::optional<std::string> file;  // to record into: a plain name, new in the server's folder; absent: no more

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("file", self.file);
  }
};

struct Step {
  static constexpr const char* kType = "step";
  std::uint64_t seq = 0;
  std::uint32_t ticks = 1;  // 1 to kMaxStepTicks

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("ticks", self.ticks);
  }
};

struct Restore {
  static constexpr const char* kType = "restore";
  std::uint64_t seq = 0;
  std::vector<std::uint8_t> snapshot;  // of SnapshotReply

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("snapshot", self.snapshot);
  }
};

// ---- Streams: client to server on the commands socket, not answered unless rejected ----

struct Pose {
  static constexpr const char* kType = "pose";
  std::string needle;          // or guide
  std::uint64_t seq = 1;       // >= 1; comes back in the states that used it
  double time = 0;             // s, on the client's own clock; not interpreted
  Vector3 position{};          // m, world, of the needle's base or the guide's hole; +-kMaxPosition
  Quaternion orientation;      // world from base, without spin; needle and hole run along +x
  std::optional<double> spin;  // rad, +-kMaxSpin, continuous over many turns, about +x; absent: as before. A guide has
                               // none

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("needle", self.needle);
    visit("seq", self.seq);
    visit("time", self.time);
    visit("position", self.position);
    visit("orientation", self.orientation);
    visit("spin", self.spin);
  }
};

struct Spin {
  static constexpr const char* kType = "spin";
  std::string needle;
  std::uint64_t seq = 1;  // >= 1, shared with `pose`
  double time = 0;        // s, on the client's own clock; not interpreted
  double spin = 0;        // rad, +-kMaxSpin

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("needle", self.needle);
    visit("seq", self.seq);
    visit("time", self.time);
    visit("spin", self.spin);
  }
};

// ---- Answers: server to client on the commands socket ----

struct NeedleInfo {
  std::string name;
  double length = 0;            // m
  double diameter = 0;          // m, outer
  std::uint32_t nodes = 0;      // first at the base, last at the tip
  Vector3 base_position{};      // m, world, after loading
  Quaternion base_orientation;  // world from base, after loading
  Vector3 cutting_direction{};  // unit, in the frame of the tip, whose axis is +x
  std::optional<double> hub_diameter{};  // m, of the face at the base that a surface stops; absent: none does

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("name", self.name);
    visit("length", self.length);
    visit("diameter", self.diameter);
    visit("nodes", self.nodes);
    visit("base_position", self.base_position);
    visit("base_orientation", self.base_orientation);
    visit("cutting_direction", self.cutting_direction);
    visit("hub_diameter", self.hub_diameter);
  }
};

struct GuideInfo {
  std::string name;
  std::string needle;      // name of the needle that slides in it
  Vector3 position{};      // m, world, of the hole after loading
  Quaternion orientation;  // world from guide, after loading; the hole runs along +x

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("name", self.name);
    visit("needle", self.needle);
    visit("position", self.position);
    visit("orientation", self.orientation);
  }
};

struct TissueInfo {
  std::uint32_t nodes = 0;
  std::uint32_t tetrahedra = 0;
  std::uint32_t triangles = 0;  // of the surface

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("nodes", self.nodes);
    visit("tetrahedra", self.tetrahedra);
    visit("triangles", self.triangles);
  }
};

struct TopicInfo {
  std::string name;
  double rate = 0;  // Hz of simulation time, of wall time for `stats`; 0: whenever it happens

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("name", self.name);
    visit("rate", self.rate);
  }
};

struct HelloReply {
  static constexpr const char* kType = "hello_reply";
  std::uint64_t seq = 0;
  std::string server;       // version of the server's program
  std::uint32_t oldest_version = kOldestVersion, newest_version = kVersion;  // of the protocol, that the server speaks
  std::uint64_t instance = 0;  // of this start of the server, drawn at random: epochs and ticks are its own
  std::vector<std::string> requests;  // that it answers, by type
  std::string scene;        // name of the scene
  std::uint64_t epoch = 0;  // see Force
  double rate = 0;          // Hz, ticks per second
  double time_step = 0;     // s, 1 / rate
  bool lockstep = false;    // ticks run only on `step`
  bool paused = false;
  std::vector<NeedleInfo> needles;
  std::vector<GuideInfo> guides;
  std::vector<std::string> held;  // needles and guides that a client holds, by name
  std::optional<std::string> recording;  // name of the file, while the server records
  std::optional<std::string> file;       // that the scene was read from, without its folder; or "the scene's text"
  TissueInfo tissue;
  std::vector<TopicInfo> topics;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("server", self.server);
    visit("oldest_version", self.oldest_version);
    visit("newest_version", self.newest_version);
    visit("instance", self.instance);
    visit("requests", self.requests);
    visit("scene", self.scene);
    visit("epoch", self.epoch);
    visit("rate", self.rate);
    visit("time_step", self.time_step);
    visit("lockstep", self.lockstep);
    visit("paused", self.paused);
    visit("needles", self.needles);
    visit("guides", self.guides);
    visit("held", self.held);
    visit("recording", self.recording);
    visit("file", self.file);
    visit("tissue", self.tissue);
    visit("topics", self.topics);
  }
};

struct NeedleRest {
  std::string name;
  std::vector<double> positions;  // m, 3 per node, world, at rest at its place after loading

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("name", self.name);
    visit("positions", self.positions);
  }
};

struct DescribeReply {
  static constexpr const char* kType = "describe_reply";
  std::uint64_t seq = 0;
  std::uint64_t epoch = 0;                        // see Force
  std::vector<float> positions;                   // m, 3 per tissue node, world, at rest
  std::vector<std::int32_t> triangles;            // 3 nodes each, counter-clockwise seen from outside
  std::vector<std::int32_t> tetrahedra;           // 4 nodes each, positive volume
  std::vector<std::string> regions;               // their names,
  std::vector<std::string> region_colours;        // and colours, "#rrggbb", or "" where the scene gives none
  std::vector<std::int32_t> tetrahedron_regions;  // index into `regions`, 1 per tetrahedron
  std::vector<NeedleRest> needles;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("epoch", self.epoch);
    visit("positions", self.positions);
    visit("triangles", self.triangles);
    visit("tetrahedra", self.tetrahedra);
    visit("regions", self.regions);
    visit("region_colours", self.region_colours);
    visit("tetrahedron_regions", self.tetrahedron_regions);
    visit("needles", self.needles);
  }
};

// Where the world stood right after the request was carried out.
struct Standing {
  std::uint64_t seq = 0;    // of the request
  std::uint64_t epoch = 0;  // see Force
  std::uint64_t tick = 0;
  double time = 0;  // s, simulation time

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("epoch", self.epoch);
    visit("tick", self.tick);
    visit("time", self.time);
  }
};

struct Done : Standing {
  static constexpr const char* kType = "done";
};

// The state after a tick as a number: what two runs have in common in every bit has the same.
struct HashReply : Standing {
  static constexpr const char* kType = "hash_reply";
  std::uint64_t hash = 0;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    Standing::fields(self, visit);
    visit("hash", self.hash);
  }
};

// The whole state after a tick.
struct SnapshotReply : Standing {
  static constexpr const char* kType = "snapshot_reply";
  std::uint64_t hash = 0;              // of the state, as in HashReply
  std::vector<std::uint8_t> snapshot;  // for `restore`; not to be looked into

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    Standing::fields(self, visit);
    visit("hash", self.hash);
    visit("snapshot", self.snapshot);
  }
};

// What the client holds after `acquire` or `release`.
struct Holding {
  static constexpr const char* kType = "holding";
  std::uint64_t seq = 0;    // of the request
  std::uint64_t epoch = 0;  // see Force
  std::vector<std::string> needles;  // and guides, by name

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("epoch", self.epoch);
    visit("needles", self.needles);
  }
};

struct Error {
  static constexpr const char* kType = "error";
  std::optional<std::uint64_t> seq;     // of the rejected message, where it could be read
  std::optional<std::string> rejected;  // its type, where it could be read
  ErrorCode code = ErrorCode::truncated;
  std::string message;  // a sentence for people

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("seq", self.seq);
    visit("rejected", self.rejected);
    visit("code", self.code);
    visit("message", self.message);
  }
};

// ---- States: server to client on the states socket; the topic is the type ----

// Forces on one needle, every tick. Ticks count without a gap within an epoch; `load`, `reset` and `restore` begin a new
// one, the first two at tick 1.
struct Force {
  static constexpr const char* kType = "force";
  std::uint64_t epoch = 0;
  std::uint64_t tick = 0;
  double time = 0;  // s, simulation time, tick * time_step
  std::string needle;
  std::uint64_t seq = 0;  // of the command in use, 0 before the first
  double age = 0;         // s of simulation time since the tick that took a command in
  double echo = 0;        // s, `time` of the command in use, on its client's clock; 0 before the first
  double fresh = 0;       // share of the last 100 ticks that took a command in
  std::uint64_t lost = 0;       // total, commands whose `seq` never came
  std::uint64_t reordered = 0;  // total, commands whose `seq` was not above the one before
  std::uint64_t limited = 0;    // total, poses beyond what the scene allows: clamped, or ignored
  bool stale = false;     // no command came for longer than the scene allows: the base rests, the haptic force is ramped
  Phase phase = Phase::free;
  double depth = 0;               // m of needle inside the tissue
  double unheld = 0;              // m of needle in tissue beside its path that no contact bears
  Vector3 base_position{};        // m, world
  Quaternion base_orientation;    // world from base, spin included
  Vector3 commanded_position{};   // m, world: where the commands have the base; apart from it only if springs hold it
  Quaternion commanded_orientation;  // likewise, spin left out
  double spin = 0;                   // rad, included in base_orientation
  Vector3 tip_position{};         // m, world
  Vector3 tip_force{};            // N, world, by the tissue on the tip
  Vector3 base_force{};           // N, world, by the needle on its holder: what a hand feels
  Vector3 base_torque{};          // N m, world, about the base, by the needle on its holder
  Vector3 base_force_in_base{};   // N, the same force in the base frame
  Vector3 base_torque_in_base{};  // N m, the same torque in the base frame
  Vector3 haptic_force{};         // N, world: base_force, ramped to zero while commands are stale; for a device
  Vector3 haptic_torque{};        // N m, world: base_torque likewise
  Vector3 cutting_force{};        // N, world, by the tissue on tip and hub: contact, friction of contact, cutting
  Vector3 friction_force{};       // N, world, by the tissue on the needle: along the path, whole shaft
  Vector3 lateral_force{};        // N, world, by the tissue on the needle: across the path, shaft and tip
  Vector3 guide_force{};          // N, world, by the guides on the needle
  Vector3 needle_force{};         // N, world, by other needles on it
  LawSolver solver = LawSolver::gauss_seidel;  // that the laws' forces of this tick come from
  std::uint32_t flags = 0;                     // bits of Flag

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("epoch", self.epoch);
    visit("tick", self.tick);
    visit("time", self.time);
    visit("needle", self.needle);
    visit("seq", self.seq);
    visit("age", self.age);
    visit("echo", self.echo);
    visit("fresh", self.fresh);
    visit("lost", self.lost);
    visit("reordered", self.reordered);
    visit("limited", self.limited);
    visit("stale", self.stale);
    visit("phase", self.phase);
    visit("depth", self.depth);
    visit("unheld", self.unheld);
    visit("base_position", self.base_position);
    visit("base_orientation", self.base_orientation);
    visit("commanded_position", self.commanded_position);
    visit("commanded_orientation", self.commanded_orientation);
    visit("spin", self.spin);
    visit("tip_position", self.tip_position);
    visit("tip_force", self.tip_force);
    visit("base_force", self.base_force);
    visit("base_torque", self.base_torque);
    visit("base_force_in_base", self.base_force_in_base);
    visit("base_torque_in_base", self.base_torque_in_base);
    visit("haptic_force", self.haptic_force);
    visit("haptic_torque", self.haptic_torque);
    visit("cutting_force", self.cutting_force);
    visit("friction_force", self.friction_force);
    visit("lateral_force", self.lateral_force);
    visit("guide_force", self.guide_force);
    visit("needle_force", self.needle_force);
    visit("solver", self.solver);
    visit("flags", self.flags);
  }
};

// The wrench on the hand at one needle's base as a function of where the base is, every tick: with a base that stands
// apart by d (translation m and rotation vector rad, world), wrench + stiffness d, while the base has gone no further
// along its own +x than `forward`, or back than `backward`.
struct Haptics {
  static constexpr const char* kType = "haptics";
  std::uint64_t epoch = 0;
  std::uint64_t tick = 0;
  double time = 0;  // s, simulation time
  std::string needle;
  std::uint64_t seq = 0;   // of the command in use, 0 before the first
  double age = 0;          // s, as in Force,
  double echo = 0;         // s, likewise,
  bool stale = false;      // likewise
  Vector3 position{};      // m, of the base after the tick, world
  Quaternion orientation;  // world from base, spin left out
  double spin = 0;         // rad
  Vector3 force{};         // N, world, by the needle on its holder, ramped to zero while commands are stale
  Vector3 torque{};        // N m, world, about the base, likewise
  std::vector<double>
      stiffness;        // 6 x 6, row by row: d(force, torque)/d(translation, rotation vector), ramped likewise
  double forward = 0;   // m, at most 1
  double backward = 0;  // m, at most 1
  ModelLimit forward_limit = ModelLimit::none, backward_limit = ModelLimit::none;
  Vector3 lasting_force{};    // N, world, as `force`, the needle's inertia and damping left out
  Vector3 lasting_torque{};   // N m, likewise
  double forward_yield = 0;   // N, 0 to 1e6: most that the laws bear along the needle
  double backward_yield = 0;  // N, likewise against a way back
  std::uint32_t flags = 0;    // bits of Flag

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("epoch", self.epoch);
    visit("tick", self.tick);
    visit("time", self.time);
    visit("needle", self.needle);
    visit("seq", self.seq);
    visit("age", self.age);
    visit("echo", self.echo);
    visit("stale", self.stale);
    visit("position", self.position);
    visit("orientation", self.orientation);
    visit("spin", self.spin);
    visit("force", self.force);
    visit("torque", self.torque);
    visit("stiffness", self.stiffness);
    visit("forward", self.forward);
    visit("backward", self.backward);
    visit("forward_limit", self.forward_limit);
    visit("backward_limit", self.backward_limit);
    visit("lasting_force", self.lasting_force);
    visit("lasting_torque", self.lasting_torque);
    visit("forward_yield", self.forward_yield);
    visit("backward_yield", self.backward_yield);
    visit("flags", self.flags);
  }
};

// The shape of one needle.
struct NeedleShape {
  static constexpr const char* kType = "needle";
  std::uint64_t epoch = 0;
  std::uint64_t tick = 0;
  double time = 0;  // s, simulation time
  std::string needle;
  std::vector<double> positions;     // m, 3 per node, world, from base to tip
  std::vector<double> orientations;  // 4 per node [w, x, y, z], world from node; +x runs along the needle

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("epoch", self.epoch);
    visit("tick", self.tick);
    visit("time", self.time);
    visit("needle", self.needle);
    visit("positions", self.positions);
    visit("orientations", self.orientations);
  }
};

// The shape of the tissue, and of the paths that needles have cut into it.
struct TissueShape {
  static constexpr const char* kType = "tissue";
  std::uint64_t epoch = 0;
  std::uint64_t tick = 0;
  double time = 0;                       // s, simulation time
  std::vector<float> positions;          // m, 3 per node, world, in the order of DescribeReply
  std::vector<float> path_points;        // m, 3 per point, world, one path after the other, each from its mouth
  std::vector<std::int32_t> path_sizes;  // points of each path
  std::vector<float> dent_centres;       // m, 3 per dent, world, on the mesh
  std::vector<float> dent_moves;         // m, 3 per dent, world
  std::vector<float> dent_radii;         // m, 2 per dent: r, R

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("epoch", self.epoch);
    visit("tick", self.tick);
    visit("time", self.time);
    visit("positions", self.positions);
    visit("path_points", self.path_points);
    visit("path_sizes", self.path_sizes);
    visit("dent_centres", self.dent_centres);
    visit("dent_moves", self.dent_moves);
    visit("dent_radii", self.dent_radii);
  }
};

struct Event {
  static constexpr const char* kType = "event";
  std::uint64_t epoch = 0;
  std::uint64_t tick = 0;
  double time = 0;  // s, simulation time
  std::string needle;
  EventKind kind = EventKind::contact;
  std::string region;  // that the tip touches or goes into; of exit and withdrawal: that it leaves
  Vector3 position{};  // m, world
  double force = 0;    // N, of the law that caused it

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("epoch", self.epoch);
    visit("tick", self.tick);
    visit("time", self.time);
    visit("needle", self.needle);
    visit("kind", self.kind);
    visit("region", self.region);
    visit("position", self.position);
    visit("force", self.force);
  }
};

// How the server did since the last `stats`, about one second of wall time; totals count from the server's start.
struct Stats {
  static constexpr const char* kType = "stats";
  std::uint64_t epoch = 0;
  std::uint64_t tick = 0;
  double time = 0;    // s, simulation time
  double period = 0;  // s of wall time that this covers
  bool paused = false;
  std::uint64_t ticks = 0;              // in the period
  double tick_p50 = 0;                  // s of computing per tick, median
  double tick_p99 = 0;                  // s, 99th percentile
  double tick_max = 0;                  // s
  std::uint64_t late = 0;               // ticks of the period that ended after the next one was due
  double wake_p50 = 0;                  // s from when a tick was due to when it began, median
  double wake_p99 = 0;                  // s
  double wake_max = 0;                  // s
  double end_p50 = 0;                   // s from when a tick was due to when all it had to say was handed on, median
  double end_p99 = 0;                   // s
  double end_max = 0;                   // s
  double residual = 0;                  // N, largest violation of a law
  std::uint32_t sweeps = 0;             // largest of the laws' solver
  std::uint32_t newton_iterations = 0;  // largest
  std::uint32_t rows = 0;               // largest number of rows of the laws
  double imbalance = 0;                 // N, largest sum of all forces on needle and tissue; 0 in exact arithmetic
  double largest_force = 0;             // N, the largest force in those sums
  std::uint64_t hash_tick = 0;          // the newest tick of the period at a full second of simulation time, or 0
  std::uint64_t hash = 0;               // of the state after it, as in HashReply
  std::uint32_t flags = 0;              // bits of Flag, of any tick
  std::uint64_t overruns = 0;           // total, deadlines skipped because a tick was late
  std::uint64_t rejected = 0;           // total, messages rejected
  std::uint64_t dropped = 0;            // total, states that the server could not pass on
  RecordingState recording = RecordingState::off;
  std::vector<std::string> subscribed;  // topics that somebody listens to

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("epoch", self.epoch);
    visit("tick", self.tick);
    visit("time", self.time);
    visit("period", self.period);
    visit("paused", self.paused);
    visit("ticks", self.ticks);
    visit("tick_p50", self.tick_p50);
    visit("tick_p99", self.tick_p99);
    visit("tick_max", self.tick_max);
    visit("late", self.late);
    visit("wake_p50", self.wake_p50);
    visit("wake_p99", self.wake_p99);
    visit("wake_max", self.wake_max);
    visit("end_p50", self.end_p50);
    visit("end_p99", self.end_p99);
    visit("end_max", self.end_max);
    visit("residual", self.residual);
    visit("sweeps", self.sweeps);
    visit("newton_iterations", self.newton_iterations);
    visit("rows", self.rows);
    visit("imbalance", self.imbalance);
    visit("largest_force", self.largest_force);
    visit("hash_tick", self.hash_tick);
    visit("hash", self.hash);
    visit("flags", self.flags);
    visit("overruns", self.overruns);
    visit("rejected", self.rejected);
    visit("dropped", self.dropped);
    visit("recording", self.recording);
    visit("subscribed", self.subscribed);
  }
};

// What travels in each direction.
using Command =
    std::variant<Hello, Describe, Acquire, Release, Hash, Snapshot, Pause, Resume, Reset, Load, Restore, Record, Step,
                 Shutdown,
                 Pose, Spin>;
using Reply = std::variant<HelloReply, DescribeReply, Holding, HashReply, SnapshotReply, Done, Error>;
using State = std::variant<Force, NeedleShape, TissueShape, Event, Stats, Haptics>;

}  // namespace acus::protocol
