// SPDX-License-Identifier: GPL-3.0-or-later
// Everything that passes between the simulation thread and the socket thread. The simulation thread never waits here:
// commands reach it as newest values, requests through a queue that it empties between ticks, and what it has to tell
// goes into one ordered queue of records of fixed size.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <variant>

#include "server/runtime/command_watch.h"
#include "server/runtime/exchange.h"
#include "server/runtime/loaded_scene.h"
#include "server/runtime/request.h"
#include "server/runtime/topics.h"
#include "server/runtime/wakeup.h"

namespace acus {

inline constexpr int kMaxBodies = kMaxNeedles + kMaxGuides;
inline constexpr std::size_t kMaxRequests = 64;   // waiting for the simulation thread
inline constexpr std::size_t kMaxRecords = 8192;  // waiting for the socket thread; about 6 MB

// A body's command and the epoch it is meant for. Epochs count the worlds: `reset`, `load` and `restore` begin a new one,
// and commands given before it do not outlive it.
struct EpochCommand {
  std::uint64_t epoch = 0;
  Command command;
  CommandOrigin origin;
  bool abandoned = false;  // in place of a command: the client whose commands it followed is gone
};

inline constexpr std::uint64_t kNoRequest = ~std::uint64_t{0};

// Records, from the simulation thread to the socket thread.
struct Acknowledgement {
  Request request;                    // that was carried out, with what comes back
  std::uint64_t epoch = 0, tick = 0;  // of the world after it
  double time = 0;                    // s
  LoadedScene* world = nullptr;       // whose states follow
};
struct ForceRecord {
  std::uint64_t epoch = 0, tick = 0;
  double time = 0;  // s
  CommandOrigin origin;
  CommandMonitor watch;
  std::uint32_t flags = 0;
  LawMethod solver = LawMethod::gauss_seidel;
  int needle = 0;
  NeedleReport report;
};
struct HapticRecord {
  ForceRecord force;
  BaseStiffness stiffness;
};
// A command that asked for more than the scene allows.
struct LimitRecord {
  std::uint64_t epoch = 0, seq = 0;
  int body = 0;
  Acceptance acceptance = Acceptance::clamped;
};
struct EventRecord {
  std::uint64_t epoch = 0;
  double time = 0;  // s
  Event event;
};
// When a tick ran. In lockstep it is due when it begins, and never late.
struct TickTiming {
  double computing = 0;  // s
  double work = 0;       // s of its thread's processor time for the whole tick; in real time only
  double woke = 0;       // s from when it was due to when it began
  double ended = 0;      // s from when it was due to when all it had to say was handed on
  bool late = false;     // it ended after the next one was due

  // Whether its own work was too much for a period (s). Being held up is not work, before it began or while it ran.
  bool overran(double period) const { return work > period; }
};
struct TickRecord {  // for `stats`
  TickTiming timing;
  std::uint32_t flags = 0;
  int rows = 0, sweeps = 0, newton_iterations = 0;
  double residual = 0, imbalance = 0, largest_force = 0;  // N
};
using Record = std::variant<Acknowledgement, ForceRecord, EventRecord, TickRecord, HapticRecord, LimitRecord>;

struct Link {
  // Socket thread to simulation thread.
  std::array<NewestValue<EpochCommand>, kMaxBodies> commands;  // per needle, then per guide
  SpscQueue<Request> requests{kMaxRequests};
  std::atomic<TopicSet> wanted{0};  // topics with a subscriber
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> abandoned{kNoRequest};  // whose client is gone: `step` goes no further
  Wakeup to_simulation;

  // Simulation thread to socket thread.
  SpscQueue<Record> records{kMaxRecords};
  std::atomic<std::uint64_t> epoch{0}, tick{0};  // of the world
  std::atomic<std::uint64_t> overruns{0};        // deadlines skipped
  std::atomic<std::uint64_t> dropped{0};         // states for which there was no room
  std::atomic<std::uint64_t> turns{0};           // of the simulation thread; one that stands still hangs
  std::atomic<bool> finished{false};             // the simulation thread does no more
  Wakeup to_sockets;
};

}  // namespace acus
