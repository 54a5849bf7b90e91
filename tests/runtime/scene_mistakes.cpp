// SPDX-License-Identifier: GPL-3.0-or-later
// Mistakes in scenes, each named with its remedy; correct scenes give no warning.
#include <doctest/doctest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "server/engine/scene/scene.h"
#include "server/runtime/scene_warnings.h"
#include "tests/support/places.h"

namespace acus {
namespace {

const std::string kScene = R"(acus_scene: 1
rate: 1000
tissue:
  mesh: {box: {size: [0.08, 0.08, 0.06], cells: [6, 6, 5]}}
  regions:
    - name: liver
      material: {young_modulus: 10e3, poisson_ratio: 0.45, density: 1000}
      interaction: {puncture_force: 0.5, cutting_force: 0.2, friction_static: 0.35, friction_dynamic: 0.3}
    - name: tumour
      sphere: {center: [0, 0, 0], radius: 0.02}
      material: {young_modulus: 30e3, poisson_ratio: 0.45, density: 1000}
      interaction: {puncture_force: 0.8, cutting_force: 0.3}
  fixed:
    - box: {max: [.inf, .inf, -0.03]}
needles:
  - name: needle
    length: 0.15
    outer_diameter: 1.2e-3
    smoothing: 5e-3
    base: {position: [0.003, 0.002, 0.21], orientation: [0.70710678, 0, 0.70710678, 0]}
)";

const std::string kOrientation = "[0.70710678, 0, 0.70710678, 0]", kBase = "[0.003, 0.002, 0.21]",
                  kMore = "smoothing: 5e-3", kTop = "rate: 1000", kLiver = "puncture_force: 0.5,",
                  kDensity = "density: 1000}\n      interaction: {puncture_force: 0.5",
                  kTumour = "    - name: tumour\n      sphere: {center: [0, 0, 0], radius: 0.02}",
                  kNeedles = "needles:\n";

std::string with(const std::string& from, const std::string& to, std::string text = kScene) {
  const auto at = text.find(from);
  REQUIRE_MESSAGE(at != std::string::npos, from);
  return text.replace(at, from.size(), to);
}

// Warnings, or the error, as text.
std::string told(const std::string& text) {
  try {
    std::string all;
    for (const SceneWarning& warning : scene_warnings(Simulation(parse_scene(text, "scene.yaml", ""))))
      all += warning.of + ": " + warning.text + "\n";
    return all;
  } catch (const SceneError& error) {
    return error.what();
  }
}

std::string guide(const std::string& fields) { return "guides: [{needle: needle, " + fields + "}]\n" + kNeedles; }

struct Mistake {
  std::string from, to;            // in the scene
  std::vector<std::string> named;  // in what is told
};

const std::vector<Mistake> kMistakes{
    // Tissue that nothing holds, or all of it
    {"  fixed:\n    - box: {max: [.inf, .inf, -0.03]}\n",
     "",
     {"tissue: no node is fixed", "tissue.fixed: [{box: {max: [.inf, .inf, -0.03]}}]"}},
    {"max: [.inf, .inf, -0.03]",
     "max: [.inf, .inf, -30]",
     {"tissue.fixed[0]", "found none inside", "to [0.04, 0.04, 0.03]"}},
    {"max: [.inf, .inf, -0.03]", "max: [.inf, .inf, .inf]", {"fixed"}},
    // Lengths
    {"[0.08, 0.08, 0.06]", "[80, 80, 60]", {"in metres", "to [36.667, 36.667, 27]"}},
    {"outer_diameter: 1.2e-3",
     "outer_diameter: 1.0",
     {"needle: outer_diameter of 1 m", "in metres: 1.2e-3 for 1.2 mm"}},
    {"outer_diameter: 1.2e-3", "outer_diameter: 1.2", {"outer_diameter", "it is in m: 0.0012 for 1.2 mm"}},
    {"outer_diameter: 1.2e-3", "outer_diameter: 0.12", {"needle: outer_diameter of 0.12 m", "in metres"}},
    {"outer_diameter: 1.2e-3", "outer_diameter: 1.2e-6", {"needle: outer_diameter of 1.2e-06 m is below", "in metres"}},
    {"length: 0.15", "length: 150", {"length", "it is in m: 0.15 for 150 mm"}},
    {"length: 0.15", "length: 0.01", {"needle: its tip is 170 mm from the tissue", "length, in metres"}},
    {"length: 0.15", "length: 5\n    constraint_spacing: 0.01", {"needle: length of 5 m"}},
    {"radius: 0.02", "radius: 20", {"put larger regions first"}},
    {"radius: 0.02", "radius: 0.0002", {"selects none", "in metres"}},
    {"center: [0, 0, 0]", "center: [0, 0, 50]", {"selects none", "in metres", "where the mesh has these from"}},
    {kBase, "[3, 2, 210]", {"[-100, 100]", "it is in m: 0.21 for 210 mm"}},
    {kBase, "[0.003, 0.002, 21]", {"needle: its base is 20.97 m from the tissue", "base.position is in metres"}},
    {kBase, "[0.003, 0.002, 0.61]", {"needle: its tip is 430 mm from the tissue"}},
    {kMore, "constraint_spacing: 4", {"needle: constraint_spacing of 4 m", "in metres: 4e-3 for 4 mm"}},
    {kNeedles, guide("play: 0.1, pose: {position: [0.003, 0.002, 0.08]}"), {"guide: play of 0.1 m", "in metres"}},
    {kTop, kTop + "\nclients: {max_step: 10}", {"clients.max_step of 10 m", "in metres"}},
    // Where needles and guides stand
    {kBase, "[0.003, 0.002, 0.021]", {"needle: its base stands inside the tissue"}},
    {kBase, "[0.003, 0.002, 0.16]", {"expected the needle's tip outside the tissue", "move the base back"}},
    {kOrientation, "[0.70710678, 0, -0.70710678, 0]", {"needle: it points away from the tissue"}},
    {kOrientation, "[1, 0, 0, 0]", {"needle: its axis leads past the tissue", "[0.7071, 0, 0.7071, 0] is down"}},
    {kOrientation, "[0, 0.70710678, 0, 0.70710678]", {"base.orientation is [w, x, y, z]"}},
    {kOrientation, "[0, 90, 0]", {"angles are no quaternion"}},
    {kOrientation, "[0, 0, 90, 0]", {"angles are no quaternion"}},
    {kOrientation, "[1, 0, 1, 0]", {"of length 1 it is [0.70711, 0, 0.70711, 0]"}},
    {kNeedles, guide("pose: {position: [0.03, 0, 0.04]}"), {"guide: it is 27.074 mm off the axis of needle"}},
    {kNeedles, guide("pose: {position: [0.003, 0.002, 0.01]}"), {"guide: it stands inside the tissue"}},
    {"max: [.inf, .inf, -0.03]", "min: [-.inf, -.inf, 0.03]", {"needle: it enters through nodes that are fixed"}},
    // Materials
    {"young_modulus: 10e3", "young_modulus: 10", {"liver: material.young_modulus of 10 Pa", "in Pa: 10e3 for 10 kPa"}},
    {"young_modulus: 10e3", "young_modulus: 0.001", {"it is in Pa: 1 for 0.001 kPa"}},
    {"young_modulus: 10e3",
     "young_modulus: 10e9",
     {"liver: material.young_modulus of 1e+10 Pa", "puncture_force: .inf"}},
    {"young_modulus: 10e3", "young_modulus: 10e12", {"liver: material.young_modulus of 1e+13 Pa"}},
    {"density: 1000", "density: 1", {"liver: material.density of 1 kg/m^3", "1000 for water"}},
    {"density: 1000", "density: 1e6", {"liver: material.density of 1e+06 kg/m^3"}},
    {"poisson_ratio: 0.45", "poisson_ratio: -0.3", {"soft tissue has 0.45 to 0.499"}},
    {"poisson_ratio: 0.45", "poisson_ratio: 0.5", {"poisson_ratio: expected a number in [0, 0.499999], found 0.5"}},
    {"poisson_ratio: 0.45", "poisson_ratio: 0.55", {"soft tissue has 0.45 to 0.499"}},
    {"poisson_ratio: 0.45", "poisson_ratio: 45", {"soft tissue has 0.45 to 0.499"}},
    {"poisson_ratio: 0.45", "poisson_ratio: 0", {"liver: material.poisson_ratio of 0", "0.45 to 0.499"}},
    {kDensity, "rayleigh_stiffness: 10, " + kDensity, {"liver: material.rayleigh_stiffness of 10 s", "0.01 for 10 ms"}},
    {kMore, "material: {young_modulus: 200}", {"E = 200 Pa", "200e9 for steel"}},
    {kMore, "material: {young_modulus: 200e3}", {"softer than rubber", "200e9 for steel"}},
    {kMore, "material: {density: 7.8}", {"needle: material.density of 7.8 kg/m^3", "7800 for steel"}},
    // Laws
    {"friction_static: 0.35, friction_dynamic: 0.3",
     "friction_static: 35, friction_dynamic: 30",
     {"liver: interaction.friction_static of 35", "liver: interaction.friction_dynamic of 30", "0.3 for 30 %"}},
    {"friction_static: 0.35, friction_dynamic: 0.3",
     "friction_static: 0.3, friction_dynamic: 0.35",
     {"friction_static", ">= friction_dynamic"}},
    {kLiver, "friction_contact: 8, " + kLiver, {"liver: interaction.friction_contact of 8"}},
    {"puncture_force: 0.5, cutting_force: 0.2",
     "puncture_force: 500, cutting_force: 200",
     {"liver: interaction.puncture_force of 500 N", "liver: interaction.cutting_force of 200 N", "0.5 for 500 mN"}},
    {kLiver, "pressure: 5, " + kLiver, {"liver: interaction.pressure of 5 Pa", "5e3 for 5 kPa"}},
    {kLiver,
     "foundation_stiffness: 40, " + kLiver,
     {"liver: interaction.foundation_stiffness of 40 Pa", "40e3 for 40 kPa"}},
    {"  fixed:",
     "  interfaces: [{between: liver, and: tumour, puncture_force: 700}]\n  fixed:",
     {"liver and tumour: puncture_force of 700 N"}},
    {"  fixed:",
     "  pressures: [{pressure: 2, box: {min: [-.inf, -.inf, 0.03]}}]\n  fixed:",
     {"tissue: pressures[0].pressure of 2 Pa", "2e3 for 2 kPa"}},
    {"  fixed:",
     "  pressures: [{pressure: 2e6, box: {min: [-.inf, -.inf, 0.03]}}]\n  fixed:",
     {"tissue: pressures[0].pressure of 2e+06 Pa presses flat"}},
    // Angles, times, rates, gravity
    {kMore, "tip: bevel\n    tip_angle: 11", {"it is in rad: 0.19199 for 11 degrees"}},
    {kTop, kTop + "\nclients: {max_turn: 5}", {"clients.max_turn of 5 rad"}},
    {kMore, "curvature: 200", {"needle: curvature of 200 1/m bends it by 1718.9 degrees"}},
    {"smoothing: 5e-3", "smoothing: 5", {"needle: smoothing of 5 s", "5e-3 for 5 ms"}},
    {kTop, kTop + "\nclients: {stale_after: 100}", {"clients.stale_after of 100 s", "0.1 for 100 ms"}},
    {kMore, "max_speed: 100", {"needle: max_speed of 100 m/s", "0.1 for 100 mm/s"}},
    {kTop, "rate: 1", {"scene: rate of 1 Hz", "1000 for 1 kHz"}},
    {kTop, "rate: 0.5", {"it is in Hz: 500 for 0.5 kHz"}},
    {kTop, kTop + "\ngravity: [0, 0, 9.81]", {"scene: gravity points up", "[0, 0, -9.81]"}},
    {kTop, kTop + "\ngravity: [0, 0, -9810]", {"scene: gravity of 9810 m/s^2"}},
    // Names and structure
    {kNeedles, kNeedles + "  - {name: needle}\n", {"needles[1].name: expected a name that no other needle has"}},
    {"name: tumour", "name: liver", {"tissue.regions[1].name: expected a name that no other region has"}},
    {"  fixed:",
     "    - {name: far, box: {min: [0.025, 0.025, -0.03], max: [0.04, 0.04, -0.015]}}\n  interfaces: [{between: "
     "tumour, and: far, puncture_force: 1}]\n  fixed:",
     {"do not touch"}},
    {kNeedles,
     "guides: [{needle: probe}]\n" + kNeedles,
     {"expected the name of a needle (\"needle\"), found \"probe\""}},
    {"young_modulus", "youngs_modulus", {"did you mean \"young_modulus\"?"}},
    // Decimal commas
    {"poisson_ratio: 0.45", "poisson_ratio: 0,45", {"a decimal point, not a comma: 0.45"}},
    {"radius: 0.02", "radius: 0,02", {"a decimal point, not a comma: 0.02"}},
    {"outer_diameter: 1.2e-3", "outer_diameter: 1,2e-3", {"a decimal point, not a comma: 1.2e-3"}},
    {kBase, "[0,003, 0,002, 0,21]", {"numbers have a decimal point, not a comma"}},
    // Regions that the mesh does not resolve
    {kTumour,
     "    - name: tumour\n      cylinder: {from: [-0.04, -0.04, 0.003], to: [0.04, 0.04, 0.01], radius: 0.0045}",
     {"tumour: the mesh makes it of 14 tetrahedra in 6 pieces that share no face, 4.98 of 7.21 cm^3 of its shape",
      "cells of 3 mm resolve it"}},
    {kTumour,
     "    - name: tumour\n      box: {min: [-0.03, -0.03, -0.001], max: [0.03, 0.03, 0.001]}",
     {"tumour: the mesh makes it of ", " mm resolve it"}},
    {kTumour, "    - name: tumour\n      half_space: {point: [0, 0, 0.029], normal: [0, 0, -1]}", {"tumour"}},
};

struct Change {
  std::string from, to;
};

// Of correct scenes.
const std::vector<Change> kVariations{
    {"young_modulus: 10e3", "young_modulus: 4e3"},
    {"young_modulus: 30e3, poisson_ratio: 0.45, density: 1000}\n      interaction: {puncture_force: 0.8",
     "young_modulus: 15e9, poisson_ratio: 0.3, density: 1900}\n      interaction: {puncture_force: .inf"},
    {"young_modulus: 30e3", "young_modulus: 5e6"},
    {"poisson_ratio: 0.45, density: 1000", "poisson_ratio: 0.3, density: 300"},
    {"poisson_ratio: 0.45", "poisson_ratio: 0.49"},
    {kDensity, "rayleigh_mass: 10, rayleigh_stiffness: 0.05, " + kDensity},
    {"puncture_force: 0.5, cutting_force: 0.2", "puncture_force: 1.5, cutting_force: 1"},
    {"puncture_force: 0.5, cutting_force: 0.2", "puncture_force: 0.06, cutting_force: 0.02"},
    {"friction_static: 0.35, friction_dynamic: 0.3", "friction_static: 1.38, friction_dynamic: 1.2, pressure: 10e3"},
    {kLiver, "pressure: 0, " + kLiver},
    {kLiver, "foundation_stiffness: .inf, " + kLiver},
    {kTop, kTop + "\ngravity: [0, 0, -9.81]\nstart: equilibrium"},
    {kTop, kTop + "\ngravity: [9.81, 0, 0]"},
    {kTop, kTop + "\ngravity: [0, 0, -1.62]"},
    {kTop, "rate: 60"},
    {kTop, "rate: 5000"},
    {kTop, kTop + "\nclients: {stale_after: .inf, max_step: 0.05, max_turn: 0.5, ramp: 0.2}"},
    {kTop, kTop + "\nlaws: {tolerance: 1e-3, solver: gauss_seidel}"},
    {"[0.08, 0.08, 0.06]", "[0.09, 0.1, 0.06]"},
    {"radius: 0.02", "radius: 0.015"},
    {"center: [0, 0, 0], radius: 0.02", "center: [0.04, 0.04, 0.03], radius: 0.03"},
    {kTumour, "    - name: tumour\n      cylinder: {from: [-0.05, 0, 0.003], to: [0.05, 0, 0.01], radius: 0.014}"},
    {kTumour, "    - name: tumour\n      box: {min: [-0.02, -0.02, -0.01], max: [0.02, 0.02, 0.01]}"},
    {kTumour, "    - name: tumour\n      half_space: {point: [0, 0, 0.006], normal: [0, 0, -1]}"},
    {"cells: [6, 6, 5]", "cells: [8, 8, 6]"},
    {"  mesh:", "  element: nodal_pressure\n  mesh:"},
    {"outer_diameter: 1.2e-3", "outer_diameter: 0.2e-3"},
    {"outer_diameter: 1.2e-3", "outer_diameter: 4e-3\n    inner_diameter: 3e-3"},
    {kMore, "material: {young_modulus: 60e9, poisson_ratio: 0.33, density: 6450}"},
    {kMore, "material: {young_modulus: 2e6, poisson_ratio: 0.45, density: 1100}"},
    {kMore, "tip: bevel\n    tip_angle: 0.3"},
    {kMore, "curvature: 6\n    curved_length: 0.03"},
    {kMore, "smoothing: 0.1\n    max_speed: 0.02\n    constraint_spacing: 1e-3"},
    {kMore, "rung: rigid"},
    {kMore, "torsional_friction: 1"},
    {kBase, "[0.003, 0.002, 0.25]"},
    {kNeedles, guide("play: 1e-4, friction: 0.3, pose: {position: [0.003, 0.002, 0.05], orientation: [0.70710678, 0, "
                     "0.70710678, 0]}")},
    {kNeedles,
     kNeedles +
         "  - {name: second, base: {position: [0.01, 0.002, 0.21], orientation: [0.70710678, 0, 0.70710678, 0]}}\n"},
    {"  fixed:", "  interfaces: [{between: liver, and: tumour, puncture_force: 0, friction_contact: 0.2}]\n  fixed:"},
    {"  fixed:", "  pressures: [{pressure: 1.6e3, box: {min: [-.inf, -.inf, 0.03]}}]\n  fixed:"},
    {"max: [.inf, .inf, -0.03]", "max: [-0.04, .inf, .inf]"},
    {"box: {max: [.inf, .inf, -0.03]}", "half_space: {point: [0, 0, -0.02]}"},
};

}  // namespace

TEST_CASE("mistakes in scenes are named with their remedy" * doctest::test_suite("gate")) {
  REQUIRE(told(kScene) == "");
  for (const Mistake& mistake : kMistakes) {
    CAPTURE(mistake.to);
    const std::string found = told(with(mistake.from, mistake.to));
    for (const std::string& part : mistake.named)
      CHECK_MESSAGE(found.find(part) != std::string::npos, part << " in " << found);
  }
}

TEST_CASE("a box in millimetres is named where no region is lost by it" * doctest::test_suite("gate")) {
  std::string text = with("[0.08, 0.08, 0.06]", "[80, 80, 60]");
  text.replace(text.find(kTumour), kTumour.size(), "    - name: tumour\n      half_space: {normal: [0, 0, -1]}");
  CHECK(told(text).find("the tissue is 80 m wide: lengths are in metres") != std::string::npos);
  CHECK(told(with(kBase, "[0.003, 0.002, 31]", text)).find("tissue: it is 80 m wide; lengths are in metres") !=
        std::string::npos);
}

TEST_CASE("cells of the size that is named resolve a region" * doctest::test_suite("gate")) {
  const std::string vessel =
      with(kTumour,
           "    - name: tumour\n      cylinder: {from: [-0.04, -0.04, 0.003], to: [0.04, 0.04, 0.01], radius: 0.0045}");
  CHECK(told(with("[6, 6, 5]", "[27, 27, 20]", vessel)) == "");
}

TEST_CASE("correct scenes are warned of nothing" * doctest::test_suite("gate")) {
  for (const auto& [from, to] : kVariations) {
    CAPTURE(to);
    CHECK(told(with(from, to)) == "");
  }
}

TEST_CASE("the scenes that come with Acus are warned of what is known" * doctest::test_suite("full")) {
  std::set<std::string> lines;
  for (const auto& each : std::filesystem::directory_iterator(source_path("scenes"))) {
    if (each.path().extension() != ".yaml") continue;
    for (const SceneWarning& warning : scene_warnings(Simulation(read_scene(each.path()))))
      lines.insert(each.path().stem().string() + ": " + warning.of + ": " + warning.text.substr(0, 19) + "\n");
  }
  std::string all;
  for (const std::string& line : lines) all += line;
  CHECK(all == "liver_insertion: liver: f_p of 1.41 N press\nliver_relaxation: liver: f_p of 1.41 N press\n");
}

}  // namespace acus
