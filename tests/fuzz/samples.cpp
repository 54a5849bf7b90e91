// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/samples.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>
#include <stdexcept>

#include "protocol/codec.h"
#include "server/engine/mesh_files/mesh_answer.h"
#include "server/engine/recording/recording.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "tests/fuzz/pushing.h"
#include "tests/support/file_content.h"
#include "tests/support/mesh_files.h"
#include "tests/support/places.h"
#include "tests/support/small_block.h"

namespace acus::fuzz {

namespace {

std::vector<std::string> files(const char* folder, const char* ending, std::size_t most = 1 << 16) {
  std::vector<std::string> all;
  for (const auto& entry : std::filesystem::directory_iterator(source_path("scenes/") + folder))
    if (entry.path().extension() == ending) all.push_back(content_of(entry.path()).substr(0, most));
  return all;
}

// Scenes without their comments, whose numbers mean nothing.
std::vector<std::string> scenes() {
  std::vector<std::string> all = files(".", ".yaml");
  static const std::regex comment(R"(\s*#[^\n]*)");
  for (std::string& text : all) text = std::regex_replace(text, comment, "");
  return all;
}

template <class... Messages>
void add_messages(std::vector<std::string>& all, const std::variant<Messages...>*) {
  (all.push_back(protocol::encode(Messages{})), ...);
}

std::vector<std::string> messages() {
  std::vector<std::string> all;
  add_messages(all, static_cast<const protocol::Command*>(nullptr));
  add_messages(all, static_cast<const protocol::Reply*>(nullptr));
  add_messages(all, static_cast<const protocol::State*>(nullptr));
  return all;
}

// In the layout of fuzz_mesh_file.cpp.
std::vector<std::string> mesh_files() {
  std::vector<std::string> all;
  for (const auto& [name, text] : test::kMeshFiles) all.push_back(static_cast<char>(255) + text);
  const std::string elements =
      test::kTetgenElements.text + std::string((16 - test::kTetgenElements.text.size() % 16) % 16, '\n');
  all.push_back(static_cast<char>(elements.size() / 16) + elements + test::kTetgenNodes.text);
  return all;
}

RawMesh small_mesh() {
  const TetrahedralMesh box = make_box_mesh({1, 1, 1}, {1, 1, 1});
  RawMesh mesh;
  mesh.coordinates.assign(box.nodes.data(), box.nodes.data() + box.nodes.size());
  for (const auto& corners : box.tetrahedra)
    mesh.tetrahedra.insert(mesh.tetrahedra.end(), corners.begin(), corners.end());
  mesh.groups = {{"", 1, "liver", {0, 1}}, {"label", -2, "", {3}}};
  mesh.notes = {"a note"};
  return mesh;
}

std::string as_text(const std::vector<char>& bytes) { return {bytes.begin(), bytes.end()}; }

// In the layout of fuzz_mesh_shape.cpp.
std::string shape_of(const std::array<int, 3>& cells) {
  const TetrahedralMesh box = make_box_mesh({0.1, 0.1, 0.1}, cells);
  std::string bytes{static_cast<char>(box.node_count()), 3, 1};
  for (const double coordinate : box.nodes.reshaped()) {
    const auto number = static_cast<std::int16_t>(std::lround(coordinate / 1e-5));
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  for (const std::array<int, 4>& corners : box.tetrahedra)
    for (const int corner : corners) bytes.push_back(static_cast<char>(corner));
  return bytes;
}

std::string image_of(const Simulation& simulation) {
  const std::vector<std::byte> image = to_bytes(simulation.state());
  return {reinterpret_cast<const char*>(image.data()), image.size()};
}

// At a few moments of an insertion.
std::vector<std::string> images() {
  Simulation simulation(test::small_block());
  std::vector<std::string> all{image_of(simulation)};
  for (const int ticks : {5, 60, 60}) {
    for (int i = 0; i < ticks; ++i) push(simulation);
    all.push_back(image_of(simulation));
  }
  return all;
}

// What follows on the beginning of a recording.
std::string items() {
  Simulation simulation(test::small_block());
  std::string bytes;
  Hasher hasher;
  for (int i = 0; i < 5; ++i) {
    append(bytes, recorded::BodyCommand{0, {.seq = 1, .pose = simulation.scene().needles[0].base, .spin = 0.1}});
    push(simulation);
    append(bytes, recorded::Tick{simulation.report().tick, digest(hasher, simulation.report()), i == 3});
  }
  append(bytes, recorded::Beginning{1, make_snapshot(simulation.model().fingerprint, simulation.state())});
  append(bytes, recorded::StateAfter{5, hash(simulation.state())});
  append(bytes, recorded::Ending{"enough"});
  return bytes;
}

}  // namespace

std::vector<std::string> samples(const std::string& target) {
  if (target == "decode") return messages();
  if (target == "scene" || target == "world") return scenes();
  if (target == "mesh_answer") return {as_text(encode_mesh(small_mesh())), as_text(encode_mesh_error("no such file"))};
  if (target == "mesh_file") return mesh_files();
  if (target == "mesh_shape") return {shape_of({1, 1, 1}), shape_of({2, 2, 2})};
  if (target == "trajectory") return files("trajectories", ".csv", 2000);
  if (target == "snapshot") return images();
  if (target == "recording") return {items()};
  throw std::runtime_error("there is no target '" + target + "'");
}

}  // namespace acus::fuzz
