// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of any values, made small, whose needles are pushed on: they are refused by name, or run with states that are
// ones and forces that are numbers.
#include <algorithm>
#include <memory>
#include <string>

#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/pushing.h"

namespace {

// What only takes time is bounded. A box stands for a mesh of a file, and a ball in it for a group of that mesh.
acus::Scene made_small(acus::Scene scene) {
  constexpr std::size_t kNeedles = 3;
  acus::Tissue& tissue = scene.tissue;
  tissue.gmsh.reset();
  for (int& cells : tissue.box.cells) cells = std::min(cells, 3);
  for (acus::Region& region : tissue.regions) {
    if (region.physical_group && &region != &tissue.regions.front()) region.sphere = acus::Sphere{.radius = 0.04};
    region.physical_group.reset();
  }
  tissue.window = std::min(tissue.window, 8);
  if (scene.needles.size() > kNeedles) scene.needles.resize(kNeedles);
  for (acus::Needle& needle : scene.needles) {
    needle.beams = std::min(needle.beams, 8);
    needle.constraint_spacing = std::max(needle.constraint_spacing, needle.length / 20);
  }
  std::erase_if(scene.guides, [&scene](const acus::Guide& guide) {
    return std::ranges::none_of(scene.needles, [&guide](const auto& needle) { return needle.name == guide.needle; });
  });
  scene.laws.max_steps = std::min(scene.laws.max_steps, 200);
  scene.newton.max_iterations = std::min(scene.newton.max_iterations, 5);
  return scene;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::unique_ptr<acus::Simulation> simulation;
  try {
    simulation = std::make_unique<acus::Simulation>(
        made_small(acus::parse_scene(std::string(acus::fuzz::text_of(data, size)), "scene.yaml")));
  } catch (const acus::SceneError&) {
    return 0;
  }
  acus::fuzz::push_on(*simulation);
  return 0;
}
