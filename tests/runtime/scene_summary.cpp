// SPDX-License-Identifier: GPL-3.0-or-later
// acus-server SCENE --check: what it says of a scene, with numbers that can be told by hand.
#include <doctest/doctest.h>

#include <sstream>

#include "server/engine/scene/text/text_table.h"
#include "server/runtime/scene_summary.h"

namespace acus {
namespace {

std::string summary_of(const std::string& text) {
  return summarise(Simulation(parse_scene("acus_scene: 1\n" + text, "scene.yaml", "")));
}

// The line that begins with this text, its columns one space apart; empty if there is none.
std::string line_of(const std::string& summary, const std::string& beginning) {
  std::istringstream lines(summary);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(beginning)) continue;
    std::istringstream words(line);
    std::string compact;
    for (std::string word; words >> word;) compact += (compact.empty() ? "" : " ") + word;
    return compact;
  }
  return "";
}

const std::string kLayers = R"(
name: layers
gravity: [0, 0, -9.81]
tissue:
  rung: exact
  mesh: {box: {size: [0.1, 0.1, 0.1], cells: [2, 2, 2]}}
  regions:
    - name: deep
      material: {young_modulus: 12e3, poisson_ratio: 0.2}
      interaction: {friction_viscous: 3, friction_thinning_speed: 2e-3, friction_exponent: 0.3, friction_back: 0.5}
    - name: skin
      box: {min: [-.inf, -.inf, 0]}
      interaction: {puncture_force: .inf, cutting_force: 0.75, pressure: 0, foundation_stiffness: .inf}
  interfaces:
    - {between: skin, and: deep, puncture_force: 0.6, friction_contact: 0.3}
  fixed:
    - box: {max: [.inf, .inf, -0.05]}
needles:
  - name: hollow
    length: 0.1
    outer_diameter: 2e-3
    inner_diameter: 1e-3
    torsional_friction: 0.5
    base: {position: [0, 0, 0.2], orientation: [0.7071068, 0, 0.7071068, 0]}
  - name: curved
    rung: rigid
    curvature: -20
    curved_length: 0.05
    base: {position: [0.01, 0, 0.3], orientation: [0.7071068, 0, 0.7071068, 0]}
guides:
  - {name: collar, needle: hollow, pose: {position: [0, 0, 0.08]}, play: 1e-4}
)";

}  // namespace

TEST_CASE("a puncture force that crushes the elements before it is reached is warned of" *
          doctest::test_suite("full")) {
  Scene scene;
  scene.tissue.box = {.size = {0.1, 0.1, 0.1}, .cells = {25, 25, 25}};  // elements of 4 mm
  Region& region = scene.tissue.regions[0];
  region.material.young_modulus = 10e3;  // E a² = 0.16 N
  scene.needles[0].base = {{0, 0, 0.25}, Quaternion::FromTwoVectors(Vector3::UnitX(), -Vector3::UnitZ())};
  scene.tissue.fixed.emplace_back().half_space = HalfSpace{{0, 0, -0.05}};
  region.interaction.puncture_force = 1.59;
  CHECK(summarise(Simulation(scene)).find("warnings") == std::string::npos);
  region.interaction.puncture_force = 1.61;
  const std::string text = summarise(Simulation(scene));
  CHECK(text.find("f_p of 1.61 N is above 10 E a^2 = 1.6 N for elements of a = 4 mm") != std::string::npos);
  CHECK(text.find("at least 4.0125 mm") != std::string::npos);
  region.interaction.puncture_force = kInfinity;  // bone is never punctured
  CHECK(summarise(Simulation(scene)).find("warnings") == std::string::npos);
}

TEST_CASE("a puncture force whose dimple is as wide as the tissue is thick is warned of") {
  Scene scene;
  scene.tissue.box = {.size = {0.1, 0.1, 0.02}, .cells = {5, 5, 2}};
  Region& region = scene.tissue.regions[0];
  region.material.young_modulus = 10e3;
  region.material.poisson_ratio = 0.45;
  scene.needles[0].base = {{0, 0, 0.25}, Quaternion::FromTwoVectors(Vector3::UnitX(), -Vector3::UnitZ())};
  scene.tissue.fixed.emplace_back().half_space = HalfSpace{{0, 0, -0.01}};
  region.interaction.puncture_force = 0.27;  // the dimple is 6.5 mm across
  CHECK(summarise(Simulation(scene)).find("warnings") == std::string::npos);
  region.interaction.puncture_force = 0.29;
  const std::string text = summarise(Simulation(scene));
  CHECK(text.find("presses a dimple of 6.7") != std::string::npos);
  CHECK(text.find("mm across into tissue that is 20 mm thick") != std::string::npos);
}

TEST_CASE("the check says what a scene contains") {
  const std::string text = summary_of(kLayers);
  CHECK(line_of(text, "scene ") == "scene layers: sound");
  CHECK(line_of(text, "rate ") == "rate 1000 Hz, a tick is 1 ms");
  CHECK(line_of(text, "rung ") == "rung exact");
  CHECK(line_of(text, "solver ") == "solver direct");
  CHECK(line_of(text, "mesh ") ==
        "mesh 27 nodes (9 fixed), 48 tetrahedra, 48 surface triangles, [0.1, 0.1, 0.1] m along the world's axes");
  CHECK(line_of(text, "  solutions") ==
        "solutions 20 in one tick, at most, of up to 1000 steps of the laws; a tick that stops there is flagged");
  CHECK(line_of(text, "  deep   24") == "deep 24 500 12000 0.2 1000 0, 0.01 none");
  CHECK(line_of(text, "  deep  1 ") ==
        "deep 1 2.1 0.5 .inf 10000 (estimated) 0.8 0.6 3, thins at 0.002 m/s (n 0.3) 0.5 estimated 1");
  CHECK(line_of(text, "  skin  .inf") == "skin .inf 2.1 0.75 .inf 0 0.8 0.6 0 1 .inf 1");
}

TEST_CASE("the check says which borders hold the tip") {
  const std::string text = summary_of(kLayers);
  CHECK(line_of(text, "  deep -> skin") == "deep -> skin 8 0.6 0.3 holds the tip");
  CHECK(line_of(text, "  skin -> deep") == "skin -> deep 8 0.6 0.3 no obstacle: f_p is not above f_c");
  CHECK(line_of(summary_of(""), "interfaces") == "");
}

TEST_CASE("the check says how stiff needles are, and what guides hold them") {
  const std::string text = summary_of(kLayers);
  // EI = 200e9 pi/64 (0.002^4 - 0.001^4) = 0.14726 N m^2.
  CHECK(line_of(text, "  hollow  flex") == "hollow flexible 50 100 2 bore 1 mm [1, 0, 0] 0.14726 441.79 36.335");
  CHECK(line_of(text, "  curved  rigid") ==
        "curved rigid 50 150 1 solid, last 50 mm bent to radius 50 mm [1, 0, 0] - - -");
  CHECK(line_of(text, "  collar") == "collar hollow [0, 0, 0.08] 0.1 0");
  CHECK(line_of(summary_of(""), "guides") == "");
}

TEST_CASE("the check says how bevels steer, in each region") {
  CHECK(line_of(summary_of(""), "bevels") == "");
  const std::string text = summary_of(
      "tissue: {regions: [{name: gel, material: {young_modulus: 75e3}}, "
      "{name: wax, box: {min: [0, -.inf, -.inf]}, interaction: {tear_strength: 1e-6}}]}\n"
      "needles: [{name: wire, tip: bevel, point_side: [0, 1, 0], material: {young_modulus: 60e9}}]");
  CHECK(line_of(text, "  wire   flex").find("as its bevel steers") != std::string::npos);
  std::istringstream arc(line_of(text, "  wire  gel"));
  std::string wire, gel, x, y, z, face;
  double radius = 0, angle = 0;
  arc >> wire >> gel >> x >> y >> z >> face >> radius >> angle;
  CHECK(face == "11");
  CHECK(radius == doctest::Approx(500).epsilon(0.05));
  CHECK(angle == doctest::Approx(1.9).epsilon(0.1));
  CHECK(line_of(text, "  wire  wax").find("wire wax [0, 1, 0] 11 ") == 0);
}

TEST_CASE("the check says what a scene will cost") {
  const Scene scene = parse_scene("acus_scene: 1\n" + kLayers, "scene.yaml", "");
  const Simulation simulation(scene);
  const Costs costs = simulation.costs();
  CHECK(costs.free_nodes == 18);
  CHECK(costs.corridor_nodes <= costs.free_nodes);
  CHECK(costs.max_rows > 0);
  CHECK(costs.factor_entries >= 3 * 18 * (3 * 18 + 1) / 4);
  const std::string text = summarise(simulation);
  CHECK(line_of(text, "  unknowns") == "unknowns 54 of 18 free nodes");
  CHECK(line_of(text, "  rows").starts_with("rows " + std::to_string(costs.max_rows) + " "));
  CHECK(line_of(text, "  factor").find(std::to_string(costs.factor_entries) + " entries, made anew") !=
        std::string::npos);
  CHECK(line_of(summary_of(""), "  factor").ends_with("entries, read twice in every tick"));
}

TEST_CASE("torsional friction and guides add rows") {
  const auto rows = [](const std::string& text) {
    return Simulation(parse_scene("acus_scene: 1\n" + text, "scene.yaml", "")).costs().max_rows;
  };
  const int plain = rows("");
  CHECK(rows("needles: [{torsional_friction: 1}]") > plain);
  CHECK(rows("guides: [{}]") == plain + 3);
}

TEST_CASE("the check says what a scene leaves out, and where to put it in") {
  const std::string layers = summary_of(kLayers);
  CHECK(line_of(layers, "  gravity") == "");
  CHECK(line_of(layers, "  supports") == "");
  CHECK(line_of(layers, "  rest at the start") ==
        "rest at the start: gravity and pressures begin to act at tick 0 set start: equilibrium");
  CHECK(line_of(layers, "  the exact tangent") == "");
  CHECK(line_of(layers, "  friction on the shaft") ==
        "friction on the shaft in skin set interaction.pressure, friction_static");
  CHECK(line_of(layers, "  the compliance beside")
            .ends_with("cannot resolve in skin set interaction.foundation_stiffness"));
  CHECK(line_of(layers, "  viscous") == "viscous friction in skin set interaction.friction_viscous");
  CHECK(line_of(layers, "  bending") == "bending of curved set rung: flexible");
  CHECK(line_of(layers, "  torsional") == "torsional friction on curved set torsional_friction");
  CHECK(line_of(layers, "  friction in") == "friction in collar set friction");
  CHECK(line_of(layers, "  contact between") == "");  // of one needle
  const std::string two = "needles: [{}, {name: beside, base: {position: [0.01, 0, 0.2]}}]\nneedle_contact: ";
  CHECK(line_of(summary_of(two + "{enabled: false}"), "  contact between") ==
        "contact between needles set needle_contact.enabled");
  CHECK(line_of(summary_of(two + "{friction: 0}"), "  friction between") ==
        "friction between needles set needle_contact.friction");

  CHECK(line_of(layers, "  relaxation") == "relaxation of the tissue in deep, skin set material.relaxation");

  const std::string relaxing =
      summary_of("tissue: {regions: [{material: {relaxation: [{ratio: 0.6, time: 0.3}, {ratio: 0.4, time: 5}]}}]}");
  CHECK(line_of(relaxing, "  tissue  4374").ends_with("0, 0.01 0.6 in 0.3 s, 0.4 in 5 s"));
  CHECK(line_of(relaxing, "  relaxation") == "");

  const std::string plain = summary_of("needles: [{name: a}, {name: b, base: {position: [0.01, 0, 0.2]}}]");
  CHECK(line_of(plain, "  gravity") == "gravity set gravity");
  CHECK(line_of(plain, "  rest at the start") == "");
  CHECK(line_of(plain, "  supports").ends_with("the tissue floats freely set tissue.fixed"));
  CHECK(line_of(plain, "  the exact tangent").ends_with("set tissue.rung: refined or exact"));
  CHECK(line_of(plain, "  torsional") == "torsional friction on a, b set torsional_friction");
  CHECK(line_of(plain, "  friction on the shaft") == "");
  CHECK(line_of(plain, "  cutting") == "");
  CHECK(line_of(summary_of("tissue: {regions: [{interaction: {cutting_force: 0}}]}"), "  cutting") ==
        "cutting in tissue set interaction.cutting_force");
}

TEST_CASE("the check says how far equilibrium has moved tissue and needles") {
  const std::string text = summary_of(kLayers + "start: equilibrium\n");
  CHECK(line_of(text, "start ").starts_with("start in equilibrium: tissue has moved by up to 4.229 mm, needles by 0"));
  CHECK(line_of(text, "start ").ends_with(" mm"));
  CHECK(line_of(text, "  rest at the start") == "");
}

TEST_CASE("the check says which stiffness a window reckons with") {
  const std::string hung = R"(
gravity: [0, 0, 9.81]
tissue:
  window: 8
  mesh: {box: {cells: [3, 3, 3]}}
  regions: [{material: {rayleigh_stiffness: 0.01}}]
  fixed: [{box: {max: [.inf, .inf, -0.0499]}}]
)";
  CHECK(line_of(summary_of(hung), "  window").ends_with("modes, about the rest shape"));
  CHECK(line_of(summary_of(hung + "start: equilibrium\n"), "  window").ends_with("modes, about the equilibrium"));
}

TEST_CASE("columns are aligned by characters, not bytes") {
  TextTable table;
  table.add({"a", "b", "c"});
  table.add({"Lamé", "x"});
  table.add({"long name", "y", "z"});
  CHECK(table.text() == "a          b  c\nLamé       x\nlong name  y  z\n");
}

}  // namespace acus
