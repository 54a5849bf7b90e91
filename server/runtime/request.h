// SPDX-License-Identifier: GPL-3.0-or-later
// What the simulation thread is asked to do between two ticks: a type for each, with what it needs and what comes back.
//
// A new request of clients has its message in protocol/messages.h, a row in transport/request_rules.h, its handling in
// transport/requests.cpp and, where the simulation thread has a part in it, a type here and its work in
// realtime_loop.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <variant>

#include "server/runtime/loaded_scene.h"
#include "server/runtime/recorder.h"

namespace acus {

// Of what begins an epoch.
struct NewEpoch {
  std::uint64_t number = 0;
  std::unique_ptr<StateBox> box;  // for the recorder, if there is one
};

namespace request {

struct Pause {};
struct Resume {};
struct Reset {
  NewEpoch epoch;
};
struct ReplaceWorld {
  NewEpoch epoch;
  std::unique_ptr<LoadedScene> world;  // comes back: the one before
};
struct Restore {
  NewEpoch epoch;
  std::unique_ptr<State> state;  // comes back, to be destroyed elsewhere
};
struct CopyState {
  std::unique_ptr<State> state;  // room for it; comes back filled
};
struct Hash : CopyState {};
struct Snapshot : CopyState {};
struct DueSnapshot : CopyState {};  // for the file that the scene asks for; no client waits
struct Record {
  Recorder* recorder = nullptr;   // null: record no more
  std::unique_ptr<StateBox> box;  // for it
};
struct Step {
  std::uint32_t ticks = 0;
};
struct Shutdown {};

}  // namespace request

struct Request {
  std::uint64_t id = 0;  // comes back in the acknowledgement
  std::variant<request::Pause, request::Resume, request::Reset, request::ReplaceWorld, request::Restore, request::Hash,
               request::Snapshot, request::DueSnapshot, request::Record, request::Step, request::Shutdown>
      what;
};

}  // namespace acus
