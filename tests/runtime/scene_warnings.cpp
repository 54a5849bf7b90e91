// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/scene_warnings.h"

#include <doctest/doctest.h>

#include <string>

#include "server/engine/scene/scene.h"

namespace acus {
namespace {

constexpr const char* kDown = "[0.7071068, 0, 0.7071068, 0]";

// All warnings of a scene as one text.
std::string warnings_of(const std::string& text) {
  std::string all;
  for (const SceneWarning& warning : scene_warnings(Simulation(parse_scene("acus_scene: 1\n" + text, "scene.yaml", ""))))
    all += warning.of + ": " + warning.text + "\n";
  return all;
}

// A block of 0.1 m with some nodes fixed, and a needle with these fields.
std::string with_needle(const std::string& fields, const std::string& tissue = "mesh: {box: {cells: [2, 2, 2]}}") {
  return "tissue: {" + tissue + ", fixed: [{box: {max: [.inf, .inf, -0.05]}}]}\nneedles: [{name: probe, length: 0.1, " + fields +
         "}]\n";
}

std::string base(const std::string& position, const std::string& orientation = kDown) {
  return "base: {position: " + position + ", orientation: " + orientation + "}";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a needle above a block is warned of nothing") { CHECK(warnings_of(with_needle(base("[0.003, 0.002, 0.16]"))) == ""); }

TEST_CASE("a needle whose base or shaft stands in the tissue is warned of") {
  const std::string up = "[0.7071068, 0, -0.7071068, 0]";
  CHECK(contains(warnings_of(with_needle(base("[0, 0, 0.01]", up))), "probe: its base stands inside the tissue"));
}

TEST_CASE("a needle that passes through the tissue is warned of") {
  const std::string text = warnings_of(
      "tissue: {mesh: {box: {size: [0.02, 0.02, 0.02], cells: [2, 2, 2]}}, fixed: [{box: {max: [.inf, .inf, -0.01]}}]}\n"
      "needles: [{name: probe, length: 0.1, " + base("[0, 0, 0.05]") + "}]\n");
  CHECK(contains(text, "probe: its shaft, 40 mm from the base, stands inside the tissue"));
}

TEST_CASE("a guide in the tissue is warned of") {
  const std::string scene = with_needle(base("[0.003, 0.002, 0.16]"));
  const auto guide = [&](const std::string& z) {
    return warnings_of(scene + "guides: [{name: collar, needle: probe, pose: {position: [0.003, 0.002, " + z +
                       "]}}]\n");
  };
  CHECK(guide("0.07") == "");
  CHECK(contains(guide("0.03"), "collar: it stands inside the tissue"));
}

TEST_CASE("a bevel that buckles in its path is warned of") {
  const auto cutting = [](const std::string& force) {
    return warnings_of(
        with_needle("tip: bevel, point_side: [0, 1, 0], outer_diameter: 0.5e-3, " + base("[0.003, 0.002, 0.16]"),
                    "mesh: {box: {cells: [2, 2, 2]}}, regions: [{interaction: {puncture_force: 1, "
                    "cutting_force: " +
                        force + "}}]"));
  };
  CHECK(cutting("0.3") == "");
  CHECK(contains(cutting("30"), "probe: the cutting force of tissue is "));
}

TEST_CASE("a needle that does not point at the tissue is warned of, with the orientation that was meant") {
  const std::string away = warnings_of(with_needle(base("[0, 0, 0.16]", "[0.7071068, 0, -0.7071068, 0]")));
  CHECK(contains(away, "probe: it points away from the tissue"));
  CHECK(contains(away, "[0.7071, 0, 0.7071, 0] is down"));
  CHECK(contains(warnings_of(with_needle(base("[0.2, 0, 0.16]"))), "probe: its axis leads past the tissue"));
  const std::string reordered = warnings_of(with_needle(base("[0, 0, 0.16]", "[0, 0.7071068, 0, 0.7071068]")));
  CHECK(contains(reordered, "base.orientation is [w, x, y, z]"));
  CHECK(contains(reordered, "[0.70711, 0, 0.70711, 0]?"));
  CHECK(warnings_of(with_needle("curvature: 5, " + base("[0.2, 0, 0.16]"))) == "");  // its path is no line
}

TEST_CASE("a needle softer than rubber is warned of") {
  CHECK(contains(warnings_of(with_needle("material: {young_modulus: 200}, " + base("[0, 0, 0.16]"))), "E = 200 Pa, softer than rubber"));
  CHECK(warnings_of(with_needle("rung: rigid, material: {young_modulus: 200}, " + base("[0, 0, 0.16]"))) == "");
}

TEST_CASE("tissue in other units than metres is warned of") {
  const std::string large = warnings_of(with_needle(base("[0, 0, 80]"), "mesh: {box: {size: [100, 100, 100], cells: [2, 2, 2]}}"));
  CHECK(contains(large, "tissue: it is 100 m wide; lengths are in metres: tissue.mesh.box.size"));
  CHECK(contains(warnings_of(with_needle(base("[0, 0, 0.16]"), "mesh: {box: {size: [0.1, 1e-3, 0.1], cells: [2, 2, 2]}}, "
                                                               "regions: [{interaction: {puncture_force: 1e-6}}]")),
                 "tissue: it is 1 mm thin"));
}

TEST_CASE("tissue that nothing holds is warned of") {
  const std::string text = "gravity: [0, 0, -9.81]\ntissue: {mesh: {box: {cells: [2, 2, 2]}}}\nneedles: [{" + base("[0, 0, 0.5]") + "}]\n";
  CHECK(contains(warnings_of(text), "tissue: no node is fixed, so that it goes away under gravity"));
  CHECK(contains(warnings_of(text.substr(text.find('\n') + 1)),
                 "tissue: no node is fixed, so that it goes away under a needle; tissue.fixed: [{box: {max: [.inf, .inf, -0.05]}}] "
                 "holds its lower face"));
}

}  // namespace acus
