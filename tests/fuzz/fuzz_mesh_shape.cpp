// SPDX-License-Identifier: GPL-3.0-or-later
// Tissue of any shape, with a needle pushed into one of its faces: a mesh is refused by what is wrong with it, or runs.
// Layout: the number of nodes, material and way of solving (a byte each); three 16-bit coordinates per node in
// hundredths of a millimetre; four bytes per tetrahedron.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>

#include "server/engine/models/geometry/tetrahedral_mesh.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/pushing.h"

namespace {

constexpr std::size_t kHead = 3, kNode = 6, kTetrahedron = 4;
constexpr double kUnit = 1e-5;  // m

acus::TetrahedralMesh mesh_of(const std::uint8_t* data, std::size_t size) {
  acus::TetrahedralMesh mesh;
  const std::size_t nodes = std::min<std::size_t>(data[0], (size - kHead) / kNode);
  mesh.nodes.resize(3, static_cast<Eigen::Index>(nodes));
  for (std::size_t i = 0; i < 3 * nodes; ++i) {
    std::int16_t coordinate = 0;
    std::memcpy(&coordinate, data + kHead + 2 * i, 2);
    mesh.nodes.data()[i] = kUnit * coordinate;
  }
  for (std::size_t at = kHead + kNode * nodes; at + kTetrahedron <= size; at += kTetrahedron)
    mesh.tetrahedra.push_back({data[at], data[at + 1], data[at + 2], data[at + 3]});
  build_topology(mesh);
  return mesh;
}

// The face whose middle is highest has a needle above it, along its normal.
acus::Scene scene_of(const acus::TetrahedralMesh& mesh, std::uint8_t material, std::uint8_t way) {
  acus::Scene scene;
  scene.rate = 500;
  acus::Region& region = scene.tissue.regions[0];
  region.material.young_modulus = std::pow(10.0, 2 + (material & 7));
  region.material.poisson_ratio = (material & 8) != 0 ? 0.45 : 0.2;
  region.interaction.puncture_force = (material & 16) != 0 ? 0.1 : 1;
  constexpr std::array kRungs{acus::TissueRung::linear, acus::TissueRung::warped, acus::TissueRung::refined,
                              acus::TissueRung::exact};
  scene.tissue.rung = kRungs[way & 3];
  scene.tissue.window = (way & 4) != 0 && scene.tissue.rung == acus::TissueRung::warped ? 4 : 0;
  if ((way & 8) != 0) scene.gravity = {0, 0, -9.81};
  if ((way & 16) != 0) scene.start = acus::Start::equilibrium;
  scene.tissue.gmsh = acus::GmshMesh{"any.msh", 1};

  double highest = -acus::kInfinity;
  acus::Vector3 middle, normal;
  for (const auto& [a, b, c] : mesh.surface) {
    const acus::Vector3 at = (mesh.nodes.col(a) + mesh.nodes.col(b) + mesh.nodes.col(c)) / 3;
    if (at.z() <= highest) continue;
    highest = at.z();
    middle = at;
    normal = (mesh.nodes.col(b) - mesh.nodes.col(a)).cross(mesh.nodes.col(c) - mesh.nodes.col(a)).normalized();
  }
  // Half of its height is held.
  acus::Volume& held = scene.tissue.fixed.emplace_back();
  held.box.emplace().max.z() = (mesh.nodes.row(2).minCoeff() + highest) / 2;
  acus::Needle& needle = scene.needles[0];
  needle.beams = 5;
  needle.length = 0.1;
  needle.base.position = middle + (needle.length + 1e-4) * normal;
  needle.base.orientation = acus::Quaternion::FromTwoVectors(acus::Vector3::UnitX(), -normal);
  return scene;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < kHead) return 0;
  std::unique_ptr<acus::Simulation> simulation;
  try {
    acus::TetrahedralMesh mesh = mesh_of(data, size);
    const acus::Scene scene = scene_of(mesh, data[1], data[2]);
    simulation = std::make_unique<acus::Simulation>(scene, acus::Progress(), std::move(mesh));
  } catch (const acus::MeshError&) {
    return 0;
  } catch (const acus::SceneError&) {
    return 0;
  }
  acus::fuzz::push_on(*simulation);
  return 0;
}
