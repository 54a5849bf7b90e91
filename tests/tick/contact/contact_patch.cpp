// SPDX-License-Identifier: GPL-3.0-or-later
// What bears a contact: points of the surface around it.
#include "server/engine/tick/contact/contact_patch.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"
#include "tests/tick/insertion/bench_insertion.h"
#include "tests/tick/notched_block.h"

namespace acus::test {
namespace {

ContactPatch patch_at(InsertionBench& bench, const Vector3& p, double radius) {
  const TissueView tissue = bench.view().tissue;
  return make_contact_patch(tissue, tissue.surface, bench.point(p), radius, kDiameter);
}

double share_of(const ContactPatch& patch) {
  double sum = 0;
  for (const MaterialPoint& point : patch.points) sum += point.weights.sum();
  return sum;
}

// As a Gmsh file: twenty tetrahedra around the origin, corners 30 mm from it.
std::string icosahedron() {
  std::vector<Vector3> nodes;
  const double golden = (1 + std::sqrt(5.0)) / 2;
  for (const double i : {-1.0, 1.0})
    for (const double j : {-golden, golden})
      for (const Vector3& p : {Vector3(0, i, j), Vector3(i, j, 0), Vector3(j, 0, i)})
        nodes.push_back(0.03 * p.normalized());
  const double edge = 2 * 0.03 / std::sqrt(1 + golden * golden) + 1e-6;
  std::ostringstream text;
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n13\n13 0 0 0\n";
  for (std::size_t i = 0; i < nodes.size(); ++i) text << i + 1 << ' ' << nodes[i].transpose() << '\n';
  text << "$EndNodes\n$Elements\n20\n";
  int count = 0;
  const auto near = [&](std::size_t i, std::size_t j) { return (nodes[i] - nodes[j]).norm() < edge; };
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = i + 1; j < nodes.size(); ++j)
      for (std::size_t k = j + 1; k < nodes.size(); ++k) {
        if (!near(i, j) || !near(j, k) || !near(k, i)) continue;
        const bool outwards = nodes[i].cross(nodes[j]).dot(nodes[k]) > 0;
        text << ++count << " 4 2 1 1 13 " << i + 1 << ' ' << (outwards ? j : k) + 1 << ' ' << (outwards ? k : j) + 1
             << '\n';
      }
  text << "$EndElements\n";
  return text.str();
}

struct Turned {
  double normal = 0;  // by a step, most
  double middle = 0;  // m
};

// Leads a contact from the middle of every triangle over each of its edges and corners in steps of a tenth of the
// needle's width.
Turned largest_turn(const std::string& file, double unit, double radius) {
  Scene scene = one_region();
  scene.tissue.gmsh = GmshMesh{file, unit};
  InsertionBench bench(scene);
  const TissueView tissue = bench.view().tissue;
  const TetrahedralMesh& mesh = tissue.mesh;
  const double step = kDiameter / 10;
  Turned most;
  const auto lead = [&](const Vector3& from, const Vector3& over) {
    const Vector3 ahead = (over - from).stableNormalized();
    std::optional<ContactPatch> before;
    Vector3 place_before = Vector3::Zero();
    for (double s = -8 * step; s < 12 * step; s += step) {
      const SurfacePoint at = tissue.surface.closest(mesh.nodes, over + s * ahead);
      const ContactPatch patch =
          make_contact_patch(tissue, tissue.surface, tissue.surface.material(at), radius, kDiameter);
      CHECK(share_of(patch) == doctest::Approx(1).epsilon(1e-12));
      const bool beside =
          before && (at.position - place_before).norm() < 1.5 * step;  // the closest point itself may jump
      if (beside) most.normal = std::max(most.normal, (patch.normal - before->normal).norm());
      if (beside) most.middle = std::max(most.middle, (patch.middle - before->middle).norm());
      before = patch;
      place_before = at.position;
    }
  };
  for (const auto& triangle : mesh.surface) {
    const Vector3 a = mesh.nodes.col(triangle[0]), b = mesh.nodes.col(triangle[1]), c = mesh.nodes.col(triangle[2]);
    for (const Vector3& over : {a, b, c, Vector3(0.3 * a + 0.7 * b)}) lead((a + b + c) / 3, over);
  }
  return most;
}

}  // namespace

TEST_CASE("led over every edge and corner, a patch turns without a jump") {
  TemporaryFolder folder;
  for (const double radius : {1e-3, 6e-3}) {
    CAPTURE(radius);
    for (const std::string& text : {icosahedron(), notched_block()}) {
      const Turned turned = largest_turn(folder.write("body.msh", text), 1, radius);
      CHECK(turned.normal < 0.2);
      CHECK(turned.middle < 0.3 * radius);
    }
  }
}

TEST_CASE("likewise on a liver") {
  const std::string liver = shared_data("meshes/sofa_liver.msh");
  if (liver.empty()) return;
  const Turned turned = largest_turn(liver, 0.034, 3e-3);
  CHECK(turned.normal < 0.6);  // at the corner of a blade, whose faces turn by more than 120 degrees
  CHECK(turned.middle < 1e-3);
}

TEST_CASE("on a flat surface the shares are equal, sum to one, and lie around the contact") {
  InsertionBench bench;
  const double radius = 5e-3;
  const ContactPatch patch = patch_at(bench, on_line(kTop), radius);
  CHECK(share_of(patch) == doctest::Approx(1).epsilon(1e-12));
  CHECK((patch.middle - on_line(kTop)).norm() < kRounding);
  CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
  CHECK(std::abs(patch.rise) < kRounding);
  double moment = 0;  // of an even load on a disc: half its radius squared
  for (MaterialPoint point : patch.points) {
    const double share = point.weights.sum();
    CHECK(share == doctest::Approx(1.0 / kPatchPoints).epsilon(1e-9));
    point.weights /= share;
    const Vector3 place = bench.position(point);
    CHECK(place.z() == doctest::Approx(kTop).epsilon(1e-9));
    moment += share * (place - on_line(kTop)).squaredNorm();
  }
  CHECK(moment == doctest::Approx(radius * radius / 2).epsilon(0.01));
}

TEST_CASE("beside an edge the tissue that is there bears nearly all, and the contact stands over the mean") {
  InsertionBench bench;
  // From the edge of the cube's top, by more than the needle's width.
  const Vector3 beside(kTop - 1.2e-3, 2e-3, kTop);
  const double radius = 8e-3;
  const ContactPatch patch = patch_at(bench, beside, radius);
  CHECK(share_of(patch) == doctest::Approx(1).epsilon(1e-12));
  double beyond = 0;  // share of the points that were brought back to the edge
  for (const MaterialPoint& point : patch.points) {
    MaterialPoint alone = point;
    alone.weights /= point.weights.sum();
    if (bench.position(alone).x() > kTop - 1e-6) beyond += point.weights.sum();
  }
  CHECK(beyond < 0.2);
  CHECK(patch.middle.x() < beside.x());
  CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
}

TEST_CASE("past an edge the side of the body does not bear, wherever rounding puts the contact") {
  InsertionBench bench;
  const Vector3 beside(kTop - 1.2e-3, 2e-3, kTop);
  for (int i = 0; i < 50; ++i) {
    const double step = 1e-15 * (i * i % 17 - 8);
    const ContactPatch patch = patch_at(bench, beside + Vector3(step, -3 * step, 0), 8e-3);
    CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
  }
}

TEST_CASE("a patch wider than the tissue is as good as one of all its face") {
  InsertionBench bench;
  const ContactPatch patch = patch_at(bench, on_line(kTop), 0.5);
  CHECK(share_of(patch) == doctest::Approx(1).epsilon(1e-12));
  CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
}

TEST_CASE("inside it lies on the border, its points in the tissue before it") {
  InsertionBench bench(two_regions(0.7));
  const TissueView tissue = bench.view().tissue;
  const MaterialPoint centre = bench.border_point(kLower, on_line(0));
  const ContactPatch patch = make_contact_patch(tissue, tissue.borders.surface(kLower), centre, 5e-3, 0);
  CHECK(share_of(patch) == doctest::Approx(1).epsilon(1e-12));
  CHECK((patch.middle - on_line(0)).norm() < kRounding);
  CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
  for (const MaterialPoint& point : patch.points) CHECK(tissue.region(point) == kUpper);
}

}  // namespace acus::test
