// SPDX-License-Identifier: GPL-3.0-or-later
// Reading scenes: defaults, values, and every kind of error with its line, column and field.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "server/engine/scene/scene.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

const std::string kHead = "acus_scene: 1\n";

Scene parse(const std::string& text) { return parse_scene(kHead + text, "scene.yaml", ""); }

// The message about the text of a whole file.
std::string file_error(const std::string& text) {
  try {
    parse_scene(text, "scene.yaml", "");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "no error";
}

// The message about the text after the version line, which is line 1.
std::string error_of(const std::string& text) { return file_error(kHead + text); }

template <class Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const SceneError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("a scene without fields has the defaults") {
  const Scene scene = parse("");
  CHECK(scene.name == "scene");
  CHECK(scene.file == "scene.yaml");
  CHECK(scene.rate == 1000);
  CHECK(scene.gravity == Vector3::Zero());
  CHECK(scene.tissue.rung == TissueRung::warped);
  CHECK_FALSE(scene.tissue.gmsh);
  CHECK(scene.tissue.box.cells == std::array<int, 3>{9, 9, 9});
  REQUIRE(scene.tissue.regions.size() == 1);
  CHECK(scene.tissue.regions[0].material.young_modulus == 10e3);
  CHECK(scene.tissue.fixed.empty());
  REQUIRE(scene.needles.size() == 1);
  CHECK(scene.needles[0].material.young_modulus == 200e9);
}

TEST_CASE("every kind of value is read") {
  const Scene scene = parse(R"(
name: "0.5"
rate: 5e2
gravity: [0, 0, -9.81]
tissue:
  rung: exact
  mesh: {box: {size: [1, 2, .3], cells: [1, 2, 3]}}
  pose: {position: [+1, -2, 3.], orientation: [0, 1.0005, 0, 0]}
  regions:
    - name: soft
    - {name: bone, physical_group: 7, box: {min: [0, -.inf, 0]}, interaction: {puncture_force: .inf}}
  fixed:
    - box: {max: [.inf, .inf, -0.05]}
    - box: {}
needles:
  - {name: a, material: {density: 7000}}
  - {name: b, beams: 3, smoothing: 0}
newton: {max_iterations: 3}
laws: {tolerance: 1e-9}
publish: {tissue_rate: 15}
)");
  CHECK(scene.name == "0.5");
  CHECK(scene.rate == 500);
  CHECK(scene.gravity == Vector3(0, 0, -9.81));
  CHECK(scene.tissue.rung == TissueRung::exact);
  CHECK(scene.tissue.box.size == Vector3(1, 2, 0.3));
  CHECK(scene.tissue.box.cells == std::array<int, 3>{1, 2, 3});
  CHECK(scene.tissue.pose.position == Vector3(1, -2, 3));
  CHECK(scene.tissue.pose.orientation.coeffs() == Quaternion(0, 1, 0, 0).coeffs());
  REQUIRE(scene.tissue.regions.size() == 2);
  CHECK(scene.tissue.regions[1].physical_group == "7");
  CHECK(scene.tissue.regions[1].box->min == Vector3(0, -kInfinity, 0));
  CHECK(scene.tissue.regions[1].interaction.puncture_force == kInfinity);
  REQUIRE(scene.tissue.fixed.size() == 2);
  CHECK(scene.tissue.fixed[0].box->max.z() == -0.05);
  CHECK(scene.tissue.fixed[1].box->min.x() == -kInfinity);
  REQUIRE(scene.needles.size() == 2);
  // A map changes what it names; the rest of the default, here steel, stays.
  CHECK(scene.needles[0].material.density == 7000);
  CHECK(scene.needles[0].material.young_modulus == 200e9);
  CHECK(scene.needles[1].beams == 3);
  CHECK(scene.newton.max_iterations == 3);
  CHECK(scene.laws.tolerance == 1e-9);
  CHECK(scene.publish.tissue_rate == 15);
  CHECK(scene.publish.needle_rate == 60);
}

TEST_CASE("what is no scene") {
  CHECK(file_error("") == "scene.yaml:1:1: expected one YAML document, found none");
  CHECK(file_error("acus_scene: 1\n---\nrate: 2\n") == "scene.yaml:1:1: expected one YAML document, found more");
  CHECK(file_error(", acus_scene: 1") == "scene.yaml:1:1: expected one YAML document, found more");
  CHECK(error_of("rate: [1\n").starts_with("scene.yaml:3:1: expected YAML, found: "));
  CHECK(error_of("needles:\n\t- length: 0.1\n").find("found a tab, which YAML does not take; replace it by spaces") !=
        std::string::npos);
  CHECK(error_of("needles: [{length: 0.1, base: {position: [0, 0").find("has no ] or }, or the file is cut off") !=
        std::string::npos);
  CHECK(error_of("needles:\n  - length: 0,15\n").find("found \"0,15\"; a decimal point, not a comma: 0.15") !=
        std::string::npos);
  CHECK(file_error("rate: [1\nacus_scene: 1\n").starts_with("scene.yaml:2:11: expected YAML, found: "));
  CHECK(file_error("{\"acus_scene\": 1,\n \"rate\": \"\\q\"}").find(": expected YAML, found: ") != std::string::npos);
  CHECK(file_error("just words").starts_with("scene.yaml:1:1: expected fields"));
  CHECK(file_error("rate: 500\n") == "scene.yaml:1:1: expected \"acus_scene: 1\", found no acus_scene");
  CHECK(file_error("acus_scene: 2\n").starts_with("scene.yaml:1:13: acus_scene: expected \"acus_scene: 1\", found 2"));
  CHECK(file_error("acus_scene: \"1\"\n").starts_with("scene.yaml:1:13: acus_scene: expected"));
}

// A client may name any file that the server can read.
TEST_CASE("an error about a file that is no scene tells nothing of what stands in it") {
  for (const std::string text : {
           "secret",                                         // one text
           "root:secret:0:0:root:/root:/bin/bash\nb:secret",  // as lists of users are written
           "- secret\n- secret",
           "secret: 5",
           "rate: secret",
           "? [secret]\n: 1",
           "name: *secret",                                  // words that yaml-cpp repeats
           "name: !<secret",
           "name: \"\\secret\"",
           "%secret\n---\nname: x",
           "%YAML secret\n---\nname: x",
           "%TAG ! secret\n%TAG ! secret\n---\nname: x",
           "!secret name",
           "secret: [1",
           "acus_scene: secret",
           "acus_scene: secret\nname: *secret",
           "acus_scene: [secret]",
           "acus_scene: 2\nsecret: secret",
           "secret: acus_scene: 1",
       }) {
    CAPTURE(text);
    const std::string error = file_error(text);
    CHECK(error.starts_with("scene.yaml:"));
    CHECK(error.find("secret") == std::string::npos);
    const TemporaryFolder folder;
    const std::string path = folder.write("file", text);
    CHECK(message_of([&path] { read_scene(path); }).find("secret") == std::string::npos);
  }
  CHECK(file_error("secret") ==
        "scene.yaml:1:1: expected fields \"name: value\" with \"acus_scene: 1\", found a text");
  CHECK(file_error("secret: [1") == "scene.yaml: expected \"acus_scene: 1\", found no such line");
}

TEST_CASE("unknown fields, with the nearest known name") {
  CHECK(error_of("rates: 2") == "scene.yaml:2:1: rates: unknown field; did you mean \"rate\"?");
  CHECK(error_of("tissue:\n  regions:\n    - material:\n        poison_ratio: 0.4") ==
        "scene.yaml:5:9: tissue.regions[0].material.poison_ratio: unknown field; did you mean \"poisson_ratio\"?");
  CHECK(error_of("laws: {xyzzy: 1}") == "scene.yaml:2:8: laws.xyzzy: unknown field; known here: solver, max_steps, tolerance");
  CHECK(error_of("needles: [{acus_scene: 1}]").starts_with("scene.yaml:2:12: needles[0].acus_scene: unknown field"));
  CHECK(error_of("tissue: {fixed: [{min: [0, 0, 0]}]}") ==
        "scene.yaml:2:19: tissue.fixed[0].min: unknown field; known here: box, sphere, half_space, cylinder");
  CHECK(error_of("[1, 2]: 3").starts_with("scene.yaml:2:1: "));
}

TEST_CASE("a field given twice") {
  CHECK(error_of("rate: 500\nname: x\nrate: 400") ==
        "scene.yaml:4:1: rate: the field stands here a second time; keep one");
  CHECK(error_of("laws: {tolerance: 1, tolerance: 1}").starts_with("scene.yaml:2:22: laws.tolerance: the field"));
}

TEST_CASE("wrong types") {
  CHECK(error_of("rate: fast") == "scene.yaml:2:7: rate: expected a number in [1, 100000], found \"fast\"");
  CHECK(error_of("rate: \"500\"") == "scene.yaml:2:7: rate: expected a number in [1, 100000], found \"500\"");
  CHECK(error_of("rate:") == "scene.yaml:2:1: rate: expected a number in [1, 100000], found nothing");
  CHECK(error_of("rate: [1]") == "scene.yaml:2:7: rate: expected a number in [1, 100000], found a list of 1");
  CHECK(error_of("rate: 5 Hz") == "scene.yaml:2:7: rate: expected a number in [1, 100000], found \"5 Hz\"");
  CHECK(error_of("rate: 0x10").starts_with("scene.yaml:2:7: rate: expected a number"));
  CHECK(error_of("rate: inf").starts_with("scene.yaml:2:7: rate: expected a number"));
  CHECK(error_of("rate: .nan").starts_with("scene.yaml:2:7: rate: expected a number"));
  CHECK(error_of("rate: 1e999").starts_with("scene.yaml:2:7: rate: expected a number"));
  CHECK(error_of("tissue: {window: 16, window_thread: yes}") ==
        "scene.yaml:2:37: tissue.window_thread: expected true or false, found \"yes\"");
  CHECK(error_of("tissue: {window: 16, window_thread: 1}").ends_with("expected true or false, found 1"));
  CHECK(error_of("tissue: {window: 16, window_thread: \"true\"}").ends_with("expected true or false, found \"true\""));
  CHECK(error_of("tissue: {window: 16, window_thread: }").ends_with("expected true or false, found nothing"));
  CHECK(error_of("name: 5") == "scene.yaml:2:7: name: expected a text, found 5; put it in quotes");
  CHECK(error_of("name: {}") == "scene.yaml:2:7: name: expected a text, found a map");
  CHECK(error_of("laws: 3") == "scene.yaml:2:7: laws: expected fields \"name: value\", found 3");
  CHECK(error_of("needles: {}") == "scene.yaml:2:10: needles: expected a list, found a map");
  CHECK(error_of("needles: [{beams: 2.5}]") ==
        "scene.yaml:2:19: needles[0].beams: expected a whole number in [1, 1000], found 2.5");
  CHECK(error_of("needles: [{beams: 1e12}]").starts_with("scene.yaml:2:19: needles[0].beams: expected a whole"));
  CHECK(error_of("gravity: [0, 0]") == "scene.yaml:2:10: gravity: expected 3 numbers [x, y, z], found a list of 2");
  CHECK(error_of("gravity: [0, 0, down]") ==
        "scene.yaml:2:17: gravity[2]: expected a number in [-10000, 10000], found \"down\"");
  CHECK(error_of("tissue: {rung: fast}") ==
        "scene.yaml:2:16: tissue.rung: expected none, linear, warped, refined or exact, found \"fast\"");
  CHECK(error_of("tissue: {pose: {orientation: [1, 0, 0]}}") ==
        "scene.yaml:2:30: tissue.pose.orientation: expected 4 numbers [w, x, y, z], found a list of 3");
  CHECK(error_of("tissue: {regions: [{physical_group: []}]}") ==
        "scene.yaml:2:37: tissue.regions[0].physical_group: expected a name or a number, found a list of 0");
  CHECK(error_of("tissue: {mesh: {}}") == "scene.yaml:2:16: tissue.mesh: expected exactly one of box or gmsh, found 0");
  CHECK(error_of("tissue: {mesh: {box: {}, gmsh: {file: x}}}") ==
        "scene.yaml:2:16: tissue.mesh: expected exactly one of box or gmsh, found 2");
}

TEST_CASE("values out of range") {
  CHECK(error_of("rate: 0") == "scene.yaml:2:7: rate: expected a number in [1, 100000], found 0");
  CHECK(error_of("rate: .inf") == "scene.yaml:2:7: rate: expected a number in [1, 100000], found .inf");
  CHECK(error_of("name: \"\"") == "scene.yaml:2:7: name: expected a text whose length is in [1, 100], found length 0");
  CHECK(error_of("gravity: [0, 0, -.inf]") ==
        "scene.yaml:2:17: gravity[2]: expected a number in [-10000, 10000], found -.inf");
  CHECK(error_of("tissue: {regions: [{material: {poisson_ratio: 0.5}}]}") ==
        "scene.yaml:2:47: tissue.regions[0].material.poisson_ratio: expected a number in [0, 0.499999], found 0.5");
  CHECK(error_of("tissue: {regions: []}") ==
        "scene.yaml:2:19: tissue.regions: expected a list whose length is in [1, 1000], found 0 entries");
  CHECK(error_of("tissue: {mesh: {box: {cells: [9, 0, 9]}}}") ==
        "scene.yaml:2:34: tissue.mesh.box.cells[1]: expected a whole number in [1, 1000], found 0");
  CHECK(error_of("needles: [{base: {orientation: [1, 1, 0, 0]}}]")
            .starts_with("scene.yaml:2:32: needles[0].base.orientation: expected a unit quaternion [w, x, y, z], "
                         "found one of length 1.414"));
  CHECK(error_of("tissue: {regions: [{interaction: {puncture_force: -1}}]}") ==
        "scene.yaml:2:51: tissue.regions[0].interaction.puncture_force: expected a number in [0, 1e+06] or .inf, found "
        "-1");
}

TEST_CASE("rates that a clock cannot keep, and publishing that would divide by them") {
  CHECK(error_of("rate: 1e300") == "scene.yaml:2:7: rate: expected a number in [1, 100000], found 1e+300");
  CHECK(error_of("rate: 1e-9") == "scene.yaml:2:7: rate: expected a number in [1, 100000], found 1e-09");
  CHECK(error_of("rate: 1e5\npublish: {needle_rate: 1e-300}") ==
        "scene.yaml:3:24: publish.needle_rate: expected a number in [0.001, 100000], found 1e-300");
  CHECK(error_of("publish: {tissue_rate: 1e-300}").starts_with("scene.yaml:2:24: publish.tissue_rate: expected"));
  CHECK(parse("rate: 1").rate == 1);
  CHECK(parse("rate: 100000").rate == 1e5);
}

TEST_CASE("what no machine or tissue is has no place in a scene") {
  CHECK(error_of("needles: [{base: {position: [0, 0, 1e308]}}]") ==
        "scene.yaml:2:36: needles[0].base.position[2]: expected a number in [-100, 100], found 1e+308");
  CHECK(error_of("needles: [{max_speed: 1e308}]").find("expected a number in [1e-06, 1e+06]") != std::string::npos);
  CHECK(error_of("needles: [{smoothing: 1e308}]").find("expected a number in [0, 1000]") != std::string::npos);
  CHECK(error_of("tissue: {regions: [{material: {density: 1e-300}}]}").find("in [1e-06, 1e+06]") != std::string::npos);
  CHECK(error_of("tissue: {regions: [{box: {max: [2e4, 0, 0]}}]}").find("in [-10000, 10000], .inf or -.inf, found") !=
        std::string::npos);
  CHECK(error_of("tissue: {regions: [{interaction: {foundation_stiffness: -.inf}}]}").find("or .inf, found -.inf") !=
        std::string::npos);
}

TEST_CASE("what is hard or unusual, but real, has a place") {
  const Scene scene = parse(R"(
tissue:
  regions:
    - material: {young_modulus: 1e12, poisson_ratio: 0.4999}
      interaction: {puncture_force: .inf, foundation_stiffness: .inf, friction_contact: 10}
    - {name: soft, material: {young_modulus: 100}, box: {min: [-.inf, -.inf, 0], max: [.inf, .inf, .inf]}}
needles: [{outer_diameter: 1e-4, material: {young_modulus: 1e12}}]
)");
  CHECK(scene.tissue.regions[0].material.young_modulus == 1e12);
  CHECK(scene.tissue.regions[0].interaction.foundation_stiffness == kInfinity);
}

TEST_CASE("what a scene needs in all is bounded") {
  CHECK(error_of("tissue: {mesh: {box: {cells: [1000, 1000, 1000]}}}") ==
        "scene.yaml:2:30: tissue.mesh.box.cells: expected at most 100000 cells in all, found 1000000000; make them "
        "larger");
  std::string many = "needles:\n";
  for (int i = 0; i < 14; ++i) many += "  - {name: n" + std::to_string(i) + "}\n";
  CHECK(error_of(many) ==
        "scene.yaml:3:3: needles: expected at most 500 constraint points of all needles together (the sum of length / "
        "the smallest constraint_spacing), found 532; raise constraint_spacing");
  CHECK(error_of("needles: [{length: 1, constraint_spacing: 0.01}, {name: b, length: 0.1, constraint_spacing: 0.001}]") ==
        "scene.yaml:2:10: needles: expected at most 500 constraint points of all needles together (the sum of length / "
        "the smallest constraint_spacing), found 1100; raise constraint_spacing");
  CHECK_NOTHROW(parse("tissue: {rung: none}\n" + many));  // without rows between needle and tissue
}

TEST_CASE("fields at odds with each other") {
  CHECK(error_of("needles: [{inner_diameter: 0.001}]") ==
        "scene.yaml:2:28: needles[0].inner_diameter: expected a number <= 0.999 outer_diameter (0.000999), found "
        "0.001; make the bore smaller or the needle thicker");
  CHECK(error_of("needles: [{constraint_spacing: 1e-5}]") ==
        "scene.yaml:2:32: needles[0].constraint_spacing: expected a number >= length / 500 (0.0003), found 1e-05");
  CHECK(error_of("tissue: {fixed: [{box: {min: [0, 0, 0], max: [1, -1, 1]}}]}") ==
        "scene.yaml:2:50: tissue.fixed[0].box.max[1]: expected a number >= min (0), found -1");
  CHECK(error_of("tissue: {regions: [{interaction: {friction_dynamic: 0.9}}]}") ==
        "scene.yaml:2:34: tissue.regions[0].interaction.friction_static: expected a number >= friction_dynamic (0.9), "
        "found 0.8 (the default)");
  CHECK(error_of("needles:\n  - {name: a}\n  - {name: a}") ==
        "scene.yaml:4:12: needles[1].name: expected a name that no other needle has, found \"a\"");
  CHECK(error_of("needles: [{}, {}]") ==
        "scene.yaml:2:15: needles[1].name: expected a name that no other needle has, found \"needle\" (the default)");
  CHECK(error_of("tissue: {regions: [{}, {}]}") ==
        "scene.yaml:2:24: tissue.regions[1].name: expected a name that no other region has, found \"tissue\" (the "
        "default)");
}

TEST_CASE("tissue that relaxes where it cannot") {
  const std::string regions = "regions: [{material: {relaxation: [{ratio: 0.5, time: 2}]}}]";
  CHECK(error_of("tissue: {" + regions + "}") == "no error");
  CHECK(error_of("tissue: {rung: refined, element: nodal_pressure, " + regions + "}") == "no error");
  CHECK(error_of("tissue: {rung: none, " + regions + "}") == "no error");
  for (const std::string rung : {"linear", "exact"})
    CHECK(error_of("tissue: {rung: " + rung + ", " + regions + "}")
              .ends_with("tissue.regions[0].material.relaxation: expected none in this tissue.rung, found some; rungs "
                         "warped and refined have it"));
  CHECK(error_of("tissue: {window: 16, " + regions + "}")
            .ends_with("relaxation: expected none with a tissue.window, found some; set tissue.window to 0"));
  CHECK(
      error_of("needles: [{material: {relaxation: [{}]}}]")
          .ends_with("needles[0].material.relaxation: expected none, as needles do not relax, found some; remove it"));
  CHECK(error_of("tissue: {regions: [{material: {relaxation: [{}, {}, {}, {}, {}]}}]}")
            .ends_with("relaxation: expected a list of at most 4 entries, found a list of 5"));
}

TEST_CASE("shapes and directions that are none") {
  CHECK(error_of("tissue: {fixed: [{}]}") ==
        "scene.yaml:2:18: tissue.fixed[0]: expected a volume with box, sphere, half_space or cylinder, found none of "
        "them");
  CHECK(error_of("tissue: {fixed: [{half_space: {normal: [0, 0, 0]}}]}") ==
        "scene.yaml:2:40: tissue.fixed[0].half_space.normal: expected a vector that is not zero; only its direction "
        "counts");
  CHECK(error_of("tissue: {regions: [{half_space: {normal: [1e-300, 0, 0]}}]}")
            .starts_with("scene.yaml:2:42: tissue.regions[0].half_space.normal: expected a vector that is not zero"));
  CHECK(error_of("tissue: {fixed: [{cylinder: {from: [1, 2, 3], to: [1, 2, 3]}}]}") ==
        "scene.yaml:2:51: tissue.fixed[0].cylinder.to: expected another point than `from`; the two are the centres of "
        "the ends");
  CHECK(error_of("tissue: {fixed: [{sphere: {radius: 0}}]}") ==
        "scene.yaml:2:36: tissue.fixed[0].sphere.radius: expected a number in [1e-06, 10000], found 0");
  CHECK(error_of("needles: [{cutting_direction: [0, 0, 0]}]")
            .starts_with("scene.yaml:2:31: needles[0].cutting_direction: expected a vector that is not zero"));
  CHECK(error_of("needles: [{cutting_direction: [0, 1, 0]}]") ==
        "scene.yaml:2:32: needles[0].cutting_direction[0]: expected a number > 0, found 0; a tip cuts forwards, along "
        "+x");
}

TEST_CASE("a point side is a bevel's, off its axis, and instead of a cutting direction") {
  CHECK(*parse("needles: [{tip: bevel, point_side: [0, 2, 0]}]").needles[0].point_side == Vector3(0, 2, 0));
  CHECK(!parse("needles: [{tip: bevel}]").needles[0].point_side);
  CHECK(error_of("needles: [{tip: trocar, point_side: [0, 1, 0]}]") ==
        "scene.yaml:2:37: needles[0].point_side: expected none at a needle whose tip is no bevel; set tip: bevel, or "
        "leave point_side out");
  CHECK(
      error_of("needles: [{tip: bevel, cutting_direction: [1, 0.1, 0], point_side: [0, 1, 0]}]") ==
      "scene.yaml:2:68: needles[0].point_side: expected none beside cutting_direction, which says where the tip cuts; "
      "leave one of them out");
  CHECK(error_of("needles: [{tip: bevel, point_side: [1, 0, 0]}]") ==
        "scene.yaml:2:36: needles[0].point_side: expected a vector off the needle's axis, as [0, 1, 0]; only its part "
        "across x counts");
}

TEST_CASE("a bevel steers by how the tissue's elasticity holds its shaft") {
  const std::string bevel = "needles: [{tip: bevel, point_side: [0, 1, 0]}]\n";
  const std::string why =
      ", as the arc follows from how the tissue's elasticity holds the shaft; leave out one of them";
  CHECK(error_of(bevel + "tissue: {local_compliance: none}") ==
        "scene.yaml:2:36: needles[0].point_side: expected none with tissue.local_compliance: none" + why);
  CHECK(error_of(bevel + "tissue: {regions: [{name: gel, interaction: {foundation_stiffness: 1e4}}]}") ==
        "scene.yaml:2:36: needles[0].point_side: expected none with foundation_stiffness of region \"gel\"" + why);
  CHECK(
      error_of("needles: [{tip: bevel, point_offset: 0.5}]") ==
      "scene.yaml:2:38: needles[0].point_offset: expected none without point_side, which says to which side it is; add "
      "it");
}

TEST_CASE("a path's strength is a force per length, or none") {
  const auto strength = [](const std::string& text) {
    return parse("tissue: {regions: [{interaction: {" + text + "}}]}").tissue.regions[0].interaction.tear_strength;
  };
  CHECK(std::isinf(strength("")));
  CHECK(strength("tear_strength: 20") == 20);
  CHECK(strength("tear_strength: 20, foundation_stiffness: 1e4") == 20);
  CHECK(error_of("tissue: {regions: [{interaction: {tear_strength: 0}}]}") ==
        "scene.yaml:2:50: tissue.regions[0].interaction.tear_strength: expected a number in [1e-06, 1e+09] or .inf, "
        "found "
        "0");
  CHECK(error_of("tissue: {regions: [{interaction: {tear_strength: 5, foundation_stiffness: .inf}}]}") ==
        "scene.yaml:2:50: tissue.regions[0].interaction.tear_strength: expected .inf with foundation_stiffness: .inf, "
        "beside which nothing tears, found 5");
  CHECK(
      error_of("tissue: {local_compliance: none, regions: [{interaction: {tear_strength: 5}}]}") ==
      "scene.yaml:2:74: tissue.regions[0].interaction.tear_strength: expected .inf with tissue.local_compliance: none, "
      "beside which nothing tears, found 5");
}

TEST_CASE("a curved end is not longer than its needle") {
  CHECK(
      error_of("needles: [{length: 0.1, curved_length: 0.11}]") ==
      "scene.yaml:2:40: needles[0].curved_length: expected a number <= length (0.1), found 0.11; leave it out to bend "
      "the whole needle");
  CHECK(error_of("needles: [{curved_length: 0}]") ==
        "scene.yaml:2:27: needles[0].curved_length: expected a number in [1e-06, 10], found 0");
  CHECK(error_of("needles: [{length: 1, beams: 2, curvature: -7}]")
            .starts_with("scene.yaml:2:44: needles[0].curvature: expected a number in (-6.28"));
  const Scene scene = parse("needles: [{length: 0.1, curvature: -5, curved_length: 0.1}]");
  CHECK(scene.needles[0].curvature == -5);
  CHECK(scene.needles[0].curved_length == 0.1);
}

TEST_CASE("interfaces name two regions, and every pair once") {
  const std::string regions = "tissue:\n  regions: [{name: a}, {name: b}, {name: c}]\n  interfaces:\n";
  CHECK(error_of(regions + "    - {between: a}") ==
        "scene.yaml:5:7: tissue.interfaces[0].and: expected a text whose length is in [1, 100], found nothing");
  CHECK(error_of(regions + "    - {between: a, and: d}") ==
        "scene.yaml:5:25: tissue.interfaces[0].and: expected the name of a region (\"a\", \"b\", \"c\"), found \"d\"");
  CHECK(error_of(regions + "    - {between: d, and: a}")
            .starts_with("scene.yaml:5:17: tissue.interfaces[0].between: expected the name of a region"));
  CHECK(error_of(regions + "    - {between: a, and: a}") ==
        "scene.yaml:5:25: tissue.interfaces[0].and: expected another region than the one in `between`, found \"a\" "
        "twice");
  CHECK(error_of(regions + "    - {between: a, and: b}\n    - {between: b, and: a}") ==
        "scene.yaml:6:7: tissue.interfaces[1]: expected every pair of regions once, found that tissue.interfaces[0] is "
        "also between \"b\" and \"a\"; keep one");
  const Scene scene = parse(regions + "    - {between: a, and: b, puncture_force: .inf}\n    - {between: c, and: b}");
  REQUIRE(scene.tissue.interfaces.size() == 2);
  CHECK(scene.tissue.interfaces[0].puncture_force == kInfinity);
  CHECK(scene.tissue.interfaces[1].and_ == "b");
  CHECK(scene.tissue.interfaces[1].puncture_force == 0);
}

TEST_CASE("a message lists a bounded number of names") {
  std::string text = "tissue:\n  interfaces: [{between: x, and: y}]\n  regions:\n";
  for (int i = 0; i < 100; ++i) text += "    - {name: region " + std::to_string(i) + "}\n";
  CHECK(error_of(text).size() < 300);
}

TEST_CASE("guides hold a needle that exists and have names of their own") {
  CHECK(error_of("guides: [{needle: probe}]") ==
        "scene.yaml:2:19: guides[0].needle: expected the name of a needle (\"needle\"), found \"probe\"");
  CHECK(error_of("needles: [{name: a}]\nguides: [{}]") ==
        "scene.yaml:3:10: guides[0].needle: expected the name of a needle (\"a\"), found \"needle\" (the default)");
  CHECK(error_of("needles: [{rung: rigid}]\nguides: [{}]").find("expected a flexible needle") != std::string::npos);
  CHECK(error_of("guides: [{name: needle}]") ==
        "scene.yaml:2:17: guides[0].name: expected a name that no other needle or guide has, found \"needle\"");
  CHECK(error_of("guides: [{name: a}, {name: a}]") ==
        "scene.yaml:2:28: guides[1].name: expected a name that no other needle or guide has, found \"a\"");
  const Scene scene = parse("guides: [{pose: {position: [0, 0, 0.1]}, play: 1e-4, friction: 0.2}]");
  REQUIRE(scene.guides.size() == 1);
  CHECK(scene.guides[0].name == "guide");
  CHECK(scene.guides[0].needle == "needle");
  CHECK(scene.guides[0].pose.position.z() == 0.1);
  CHECK(scene.guides[0].play == 1e-4);
  CHECK(scene.guides[0].friction == 0.2);
}

TEST_CASE("needles of other kinds") {
  const Scene scene = parse(
      "needles:\n  - {name: a, rung: rigid}\n"
      "  - {name: b, cutting_direction: [1, 0.1, 0], torsional_friction: 0.5}");
  CHECK(scene.needles[0].rung == NeedleRung::rigid);
  CHECK(scene.needles[0].cutting_direction == Vector3::UnitX());
  CHECK(scene.needles[0].torsional_friction == 0);
  CHECK(scene.needles[1].rung == NeedleRung::flexible);
  CHECK(scene.needles[1].cutting_direction == Vector3(1, 0.1, 0));
  CHECK(scene.needles[1].torsional_friction == 0.5);
  CHECK(error_of("needles: [{rung: stiff}]") ==
        "scene.yaml:2:18: needles[0].rung: expected flexible or rigid, found \"stiff\"");
}

TEST_CASE("the pressure on a shaft is given or estimated") {
  const Scene scene = parse(
      "tissue: {regions: [{name: a, material: {young_modulus: 15e3, poisson_ratio: 0.5e-1}}, "
      "{name: b, interaction: {pressure: 0}}]}");
  CHECK(shaft_pressure(scene.tissue.regions[0]) == doctest::Approx(15e3 / 1.05));
  CHECK(shaft_pressure(scene.tissue.regions[1]) == 0);
}

TEST_CASE("a list that is too long") {
  std::string many = "needles: [";
  for (int i = 0; i < 65; ++i) many += "{name: n" + std::to_string(i) + "}, ";
  CHECK(error_of(many + "]") == "scene.yaml:2:10: needles: expected a list of at most 64 entries, found a list of 65");
}

TEST_CASE("mesh files are looked up beside the scene") {
  const TemporaryFolder folder;
  folder.write("mesh.msh", "$MeshFormat");
  const std::string with_mesh = kHead + "tissue: {mesh: {gmsh: {file: mesh.msh}}}";
  CHECK(read_scene(folder.write("scene.yaml", with_mesh)).tissue.gmsh->file == folder.path() + "/mesh.msh");
  CHECK(parse_scene(with_mesh, "scene.yaml", folder.path()).tissue.gmsh->file == folder.path() + "/mesh.msh");
  CHECK(error_of("tissue: {mesh: {gmsh: {file: no.msh}}}") ==
        "scene.yaml:2:30: tissue.mesh.gmsh.file: expected a mesh file at \"no.msh\", found: No such file or directory");
  CHECK(error_of("tissue: {mesh: {gmsh: {}}}") ==
        "scene.yaml:2:23: tissue.mesh.gmsh.file: expected a text whose length is in [1, 4096], found nothing");
}

TEST_CASE("a scene file that cannot be read") {
  CHECK(message_of([] { read_scene("no/such.yaml"); }) ==
        "no/such.yaml: expected a scene file, found: No such file or directory");
  const TemporaryFolder folder;
  CHECK(message_of([&folder] { read_scene(folder.path()); }).starts_with(folder.path() + ": expected a scene file"));
  const std::string large = folder.write("large.yaml", std::string(5 << 20, '#'));
  CHECK(message_of([&large] { read_scene(large); }).starts_with(large + ": expected a scene of at most"));
}

TEST_CASE("a scene built in code is checked alike, without places") {
  Scene scene;
  CHECK(message_of([&scene] { validate(scene); }) == "no error");
  scene.tissue.regions[0].material.poisson_ratio = std::numeric_limits<double>::quiet_NaN();
  CHECK(message_of([&scene] { validate(scene); }) ==
        "tissue.regions[0].material.poisson_ratio: expected a number in [0, 0.499999], found .nan");
}

TEST_CASE("the default scene is what the documents promise") {
  const Scene scene = read_scene(source_path("scenes/insertion_pullback.yaml"));
  const TetrahedralMesh mesh = load_mesh(scene);
  const std::vector<bool> fixed = find_fixed_nodes(scene, mesh);
  CHECK(mesh.node_count() == 1000);
  CHECK(std::count(fixed.begin(), fixed.end(), true) == 100);
  CHECK(scene.rate >= 500);

  const Needle& needle = scene.needles.at(0);
  const Vector3 tip = needle.base * Vector3(needle.length, 0, 0);
  CHECK((tip - Vector3(-0.003, -0.002, 0.06)).norm() < 1e-9);

  const Region& region = scene.tissue.regions.at(0);
  const Interaction& interaction = region.interaction;
  const double pressure_on_a_metre = std::numbers::pi * needle.outer_diameter * shaft_pressure(region);
  CHECK(pressure_on_a_metre * interaction.friction_dynamic == doctest::Approx(20).epsilon(1e-6));
  CHECK(interaction.friction_static == doctest::Approx(1.15 * interaction.friction_dynamic));
}

}  // namespace acus
