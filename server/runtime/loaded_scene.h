// SPDX-License-Identifier: GPL-3.0-or-later
// A loaded scene with everything that belongs to it and goes when it goes: the simulation, room for its shapes on their
// way to the publisher, and what clients are told about it.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "protocol/messages.h"
#include "server/engine/recording/recording.h"
#include "server/engine/tick/drawn_tissue.h"
#include "server/engine/tick/simulation.h"
#include "server/runtime/exchange.h"

namespace acus {

struct NeedleFrame {
  int needle = 0;
  protocol::NeedleShape shape;  // buffers sized for the largest needle of the scene; the publisher adds the name
};

// A state on its way from the simulation thread, which fills the box where it is not full, to the one that empties it.
struct StateBox {
  std::atomic<bool> full{false};
  std::uint64_t epoch = 0;
  State state;
};

struct LoadedScene {
  explicit LoadedScene(const Scene& scene, const Progress& progress = {});  // throws SceneError
  LoadedScene(const Scene& scene, TetrahedralMesh own_mesh, const Progress& progress);

  Simulation simulation;  // of the simulation thread while it has the world

  // From the simulation thread to the publisher.
  SpscQueue<NeedleFrame> needle_frames;
  SpscQueue<protocol::TissueShape> tissue_frames;  // with room for every path at its longest

  StateBox second;  // after a tick at a full second of simulation time, for `stats`

  DrawnTissue drawn;  // scratch of the simulation thread

  // Constant.
  std::shared_ptr<const recorded::World> recorded;
  std::uint64_t needle_frame_ticks;  // ticks between two needle shapes, >= 1
  std::uint64_t tissue_frame_ticks;  // ticks between two tissue shapes, >= 1
  std::uint64_t second_ticks;        // ticks of a second of simulation time, >= 1
  protocol::HelloReply hello;        // all but what depends on the request and the moment
  protocol::DescribeReply describe;  // likewise

  // What takes commands: the needles in the order of the scene, then the guides.
  int body_count() const { return static_cast<int>(hello.needles.size() + hello.guides.size()); }
  bool is_guide(int body) const { return body >= static_cast<int>(hello.needles.size()); }

  // Number of the needle or guide with that name, or -1.
  int find_body(const std::string& name) const;
  const std::string& body_name(int body) const;
};

// What clients are told about a simulation: all but what depends on the request and the moment.
protocol::HelloReply hello_of(const Simulation& simulation);
protocol::DescribeReply describe_of(const Simulation& simulation);
// Of ticks at `rate` (Hz), from one that is published to the next, >= 1.
std::uint64_t ticks_between(double rate, double published_rate);

// Builds the world of a scene, step by step as the log says; `rate` (Hz) replaces the scene's. With `allowed`,
// its mesh file must lie in these folders. Throws SceneError.
std::unique_ptr<LoadedScene> load_scene(Scene scene, std::optional<double> rate, const SceneFolders* allowed = nullptr);
// That of a recorded scene, which the log has heard of already. Throws RecordingError, too.
std::unique_ptr<LoadedScene> load_scene(const recorded::World& world);
// Tells the log what is done.
void tell_loading(const char* what);

}  // namespace acus
