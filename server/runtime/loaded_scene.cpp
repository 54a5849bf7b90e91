// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/loaded_scene.h"

#include <spdlog/spdlog.h>
#include <spdlog/stopwatch.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "server/engine/state/placement.h"
#include "server/runtime/convert.h"
#include "server/runtime/topics.h"

namespace acus {
namespace {

constexpr std::size_t kFrames = 8;  // of each shape, waiting for the publisher

std::size_t largest_node_count(const Simulation& simulation) {
  int largest = 0;
  for (int i = 0; i < static_cast<int>(simulation.scene().needles.size()); ++i) {
    largest = std::max(largest, simulation.needle_node_count(i));
  }
  return static_cast<std::size_t>(largest);
}

std::vector<protocol::TopicInfo> topic_rates(const Scene& scene) {
  const auto shapes = [&scene](double rate) {
    return scene.rate / static_cast<double>(ticks_between(scene.rate, rate));
  };
  std::vector<protocol::TopicInfo> topics;
  for (const char* name : kTopicNames) topics.push_back({name, 0});
  topics[static_cast<int>(Topic::force)].rate = topics[static_cast<int>(Topic::haptics)].rate = scene.rate;
  topics[static_cast<int>(Topic::needle)].rate = shapes(scene.publish.needle_rate);
  topics[static_cast<int>(Topic::tissue)].rate = shapes(scene.publish.tissue_rate);
  topics[static_cast<int>(Topic::stats)].rate = 1;
  return topics;
}

template <std::size_t N>
std::vector<std::int32_t> flatten(const std::vector<std::array<int, N>>& rows) {
  std::vector<std::int32_t> flat;
  flat.reserve(rows.size() * N);
  for (const auto& row : rows) flat.insert(flat.end(), row.begin(), row.end());
  return flat;
}

}  // namespace

std::uint64_t ticks_between(double rate, double published_rate) {
  return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(rate / published_rate)));
}

protocol::HelloReply hello_of(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  protocol::HelloReply hello;
  hello.server = ACUS_VERSION;  // defined by the build
  hello.scene = scene.name;
  if (!scene.file.empty()) hello.file = std::filesystem::path(scene.file).filename().string();
  hello.rate = scene.rate;
  hello.time_step = 1 / scene.rate;
  for (int i = 0; i < static_cast<int>(scene.needles.size()); ++i) {
    const Needle& needle = scene.needles[i];
    hello.needles.push_back({needle.name, needle.length, needle.outer_diameter,
                             static_cast<std::uint32_t>(simulation.needle_node_count(i)), to_wire(needle.base.position),
                             to_wire(needle.base.orientation), to_wire(simulation.model().cutting_direction(i)),
                             needle.hub_diameter > 0 ? std::optional(needle.hub_diameter) : std::nullopt});
  }
  for (const Guide& guide : scene.guides) {
    hello.guides.push_back({guide.name, guide.needle, to_wire(guide.pose.position), to_wire(guide.pose.orientation)});
  }
  const TetrahedralMesh& mesh = simulation.mesh();
  hello.tissue = {static_cast<std::uint32_t>(mesh.nodes.cols()), static_cast<std::uint32_t>(mesh.tetrahedra.size()),
                  static_cast<std::uint32_t>(mesh.surface.size())};
  hello.topics = topic_rates(scene);
  return hello;
}

protocol::DescribeReply describe_of(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  const TetrahedralMesh& mesh = simulation.mesh();
  protocol::DescribeReply describe;
  describe.positions.resize(static_cast<std::size_t>(mesh.nodes.size()));
  pack(mesh.nodes, describe.positions);
  describe.triangles = flatten(mesh.surface);
  describe.tetrahedra = flatten(mesh.tetrahedra);
  if (!scene.tissue.left_out()) {
    for (const Region& region : scene.tissue.regions) {
      const std::string colour = region.colour.value_or("");
      describe.regions.push_back(region.name);
      describe.region_colours.push_back(colour.empty() || colour.starts_with('#') ? colour : "#" + colour);
    }
  }
  const std::span<const int> regions = simulation.regions();
  describe.tetrahedron_regions.assign(regions.begin(), regions.end());
  const State loaded = make_state(simulation.model());
  for (int i = 0; i < static_cast<int>(scene.needles.size()); ++i) {
    protocol::NeedleRest rest{scene.needles[i].name, {}};
    const auto& positions = loaded.needles[i].x;
    rest.positions.resize(static_cast<std::size_t>(positions.size()));
    pack(positions, rest.positions);
    describe.needles.push_back(std::move(rest));
  }
  return describe;
}

LoadedScene::LoadedScene(const Scene& scene, const Progress& progress)
    : LoadedScene(scene, read_mesh(scene), progress) {}

LoadedScene::LoadedScene(const Scene& scene, TetrahedralMesh own_mesh, const Progress& progress)
    : simulation(scene, progress, own_mesh),
      needle_frames(kFrames * scene.needles.size()),
      tissue_frames(kFrames),
      drawn(simulation.model()),
      recorded(std::make_shared<recorded::World>(record_of(scene, own_mesh, simulation.model().fingerprint))),
      needle_frame_ticks(ticks_between(scene.rate, scene.publish.needle_rate)),
      tissue_frame_ticks(ticks_between(scene.rate, scene.publish.tissue_rate)),
      second_ticks(ticks_between(scene.rate, 1)),
      hello(hello_of(simulation)),
      describe(describe_of(simulation)) {
  second.state = simulation.state();
  const std::size_t needle_nodes = largest_node_count(simulation);
  for (NeedleFrame& frame : needle_frames.slots()) {
    frame.shape.positions.reserve(3 * needle_nodes);
    frame.shape.orientations.reserve(4 * needle_nodes);
  }
  for (protocol::TissueShape& shape : tissue_frames.slots()) {
    shape.positions.resize(describe.positions.size());
    shape.path_points.reserve(static_cast<std::size_t>(drawn.path_points.size()));
    shape.path_sizes.reserve(drawn.path_sizes.capacity());
    shape.dent_centres.reserve(3 * drawn.dents.capacity());
    shape.dent_moves.reserve(3 * drawn.dents.capacity());
    shape.dent_radii.reserve(2 * drawn.dents.capacity());
  }
}

int LoadedScene::find_body(const std::string& name) const {
  const auto named = [&](const auto& info) { return info.name == name; };
  const auto needle = std::find_if(hello.needles.begin(), hello.needles.end(), named);
  if (needle != hello.needles.end()) return static_cast<int>(needle - hello.needles.begin());
  const auto guide = std::find_if(hello.guides.begin(), hello.guides.end(), named);
  if (guide != hello.guides.end()) return static_cast<int>(hello.needles.size() + (guide - hello.guides.begin()));
  return -1;
}

const std::string& LoadedScene::body_name(int body) const { return acus::body_name(simulation.scene(), body); }

std::unique_ptr<LoadedScene> load_scene(Scene scene, std::optional<double> rate, const SceneFolders* allowed) {
  if (rate) scene.rate = *rate;
  const spdlog::stopwatch since_start;
  tell_loading("mesh");
  TetrahedralMesh mesh = read_mesh(scene, allowed);
  for (const std::string& note : mesh.notes) spdlog::info("mesh file: {}", note);
  auto world = std::make_unique<LoadedScene>(scene, std::move(mesh), tell_loading);
  spdlog::info("loaded in {:.2f} s", since_start);
  return world;
}

std::unique_ptr<LoadedScene> load_scene(const recorded::World& world) {
  RecordedScene recorded = scene_of(world);
  TetrahedralMesh mesh = recorded.own_mesh ? std::move(*recorded.own_mesh) : read_mesh(recorded.scene);
  return std::make_unique<LoadedScene>(recorded.scene, std::move(mesh), Progress());
}

void tell_loading(const char* what) { spdlog::info("loading: {}", what); }

}  // namespace acus
