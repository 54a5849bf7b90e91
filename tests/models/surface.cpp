// SPDX-License-Identifier: GPL-3.0-or-later
// Finding the tissue's surface and walking through its tetrahedra, on a box whose answers are known.
#include "server/models/surface.h"

#include <doctest/doctest.h>

#include "tests/support/random.h"

namespace acus {
namespace {

const Vector3 kHalf(0.05, 0.04, 0.06);

TetrahedralMesh box() { return make_box_mesh(2 * kHalf, {5, 4, 6}); }  // cells of 20 mm

bool inside_box(const Vector3& p) { return (p.array().abs() <= kHalf.array() + 1e-12).all(); }

// Affine, turning and shearing; answers on the box carry over to the deformed box.
Matrix3X deformed(const TetrahedralMesh& mesh) {
  Matrix3 f = rotation_exp({0.4, -0.7, 1.1}).toRotationMatrix();
  f(0, 1) += 0.2;
  return (f * mesh.nodes).colwise() + Vector3(0.3, 0.1, -0.2);
}

std::vector<int> tetrahedra_at(const TetrahedralMesh& mesh, const Vector3& p) {
  std::vector<int> found;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    if (barycentric(mesh, mesh.nodes, t, p).minCoeff() > -1e-12) found.push_back(t);
  return found;
}

// Traces from every tetrahedron that holds `from`.
void check_trace(const TetrahedralMesh& mesh, const Vector3& from, const Vector3& to, const Vector3& expected,
                 bool leaves) {
  CAPTURE(from.transpose());
  CAPTURE(to.transpose());
  for (const int start : tetrahedra_at(mesh, from)) {
    const Trace trace = trace_segment(mesh, mesh.nodes, start, from, to);
    CHECK(trace.left == leaves);
    CHECK((material_position(mesh, mesh.nodes, trace.end) - expected).norm() < 1e-9);
    CHECK(trace.end.weights.minCoeff() > -1e-7);
    CHECK(trace.end.weights.sum() == doctest::Approx(1));
  }
}

// Where the ray from inside leaves the box.
Vector3 exit_point(const Vector3& from, const Vector3& to) {
  double s = 1;
  for (int k = 0; k < 3; ++k) {
    const double along = to[k] - from[k];
    if (along != 0) s = std::min(s, (std::copysign(kHalf[k], along) - from[k]) / along);
  }
  return from + s * (to - from);
}

Vector3 random_inside(Random& random) {
  return {random.uniform(-kHalf.x(), kHalf.x()), random.uniform(-kHalf.y(), kHalf.y()),
          random.uniform(-kHalf.z(), kHalf.z())};
}

TEST_CASE("barycentric coordinates reproduce the point, and a flat tetrahedron has some") {
  const TetrahedralMesh mesh = box();
  Random random(1);
  for (int t = 0; t < mesh.tetrahedron_count(); t += 7) {
    const Vector3 p = random.vector(0.1);
    const Eigen::Vector4d w = barycentric(mesh, mesh.nodes, t, p);
    CHECK((material_position(mesh, mesh.nodes, {t, w}) - p).norm() < 1e-14);
    CHECK(w.sum() == doctest::Approx(1));
  }
  const Matrix3X flat = Vector3(1, 1, 0).asDiagonal() * mesh.nodes;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) CHECK(barycentric(mesh, flat, t, {0.01, 0.02, 0.03}).allFinite());
}

TEST_CASE("a segment is followed through the tetrahedra to its end") {
  const TetrahedralMesh mesh = box();
  Random random(2);
  for (int repeat = 0; repeat < 500; ++repeat) {
    const Vector3 from = random_inside(random), to = random_inside(random);
    check_trace(mesh, from, to, to, false);
  }
}

TEST_CASE("a segment that leaves ends on the boundary") {
  const TetrahedralMesh mesh = box();
  Random random(3);
  for (int repeat = 0; repeat < 500; ++repeat) {
    const Vector3 from = random_inside(random), to = 0.3 * random.direction();
    check_trace(mesh, from, to, exit_point(from, to), true);
  }
}

TEST_CASE("segments along edges, faces and through nodes find their end") {
  const TetrahedralMesh mesh = box();
  const Vector3 directions[] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1},  {1, 1, 0}, {1, -1, 0}, {0, 1, 1},
                                {1, 0, 1}, {1, 1, 1},  {-1, 1, 1}, {1, 2, 0}, {2, 1, 1},  {-1, -1, -1}};
  for (const Vector3& start : {Vector3(0.01, 0, 0), Vector3(-0.01, 0.02, -0.02), Vector3(0, 0, 0),
                               Vector3(0.01, 0.01, 0.01), Vector3(0.015, 0.005, 0.005)}) {
    for (const Vector3& d : directions) {
      check_trace(mesh, start, start + 0.009 * d, start + 0.009 * d, false);
      const Vector3 far = start + 0.5 * d;
      check_trace(mesh, start, far, exit_point(start, far), true);
    }
  }
}

TEST_CASE("between any two nodes") {
  const TetrahedralMesh mesh = box();
  Random random(4);
  for (int repeat = 0; repeat < 300; ++repeat) {
    const Vector3 from = mesh.nodes.col(random.index(mesh.node_count()));
    const Vector3 to = mesh.nodes.col(random.index(mesh.node_count()));
    check_trace(mesh, from, to, to, false);
  }
}

TEST_CASE("a segment of no length stays") {
  const TetrahedralMesh mesh = box();
  check_trace(mesh, {0.01, 0, 0}, {0.01, 0, 0}, {0.01, 0, 0}, false);
  check_trace(mesh, {0.003, 0.004, 0.005}, {0.003, 0.004, 0.005}, {0.003, 0.004, 0.005}, false);
}

TEST_CASE("tracing follows the deformed tissue") {
  const TetrahedralMesh mesh = box();
  const Matrix3X x = deformed(mesh);
  Random random(5);
  for (int repeat = 0; repeat < 100; ++repeat) {
    const Vector3 from = random_inside(random), to = random_inside(random);
    const int start = tetrahedra_at(mesh, from).front();
    const MaterialPoint a{start, barycentric(mesh, mesh.nodes, start, from)};
    const int end = tetrahedra_at(mesh, to).front();
    const MaterialPoint b{end, barycentric(mesh, mesh.nodes, end, to)};
    const Trace trace = trace_segment(mesh, x, start, material_position(mesh, x, a), material_position(mesh, x, b));
    CHECK_FALSE(trace.left);
    CHECK((material_position(mesh, mesh.nodes, trace.end) - to).norm() < 1e-9);  // the same material
  }
}

TEST_CASE("a segment from outside enters at the first crossing") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  Random random(6);
  for (int repeat = 0; repeat < 300; ++repeat) {
    const Vector3 outside = 0.2 * random.direction(), target = random_inside(random);
    const auto entry = surface.entry(mesh.nodes, outside, 2 * target - outside);  // through, and out again
    const Vector3 expected = exit_point(target, outside);
    REQUIRE(entry);
    CHECK((entry->position - expected).norm() < 1e-9);
    CHECK(entry->weights.sum() == doctest::Approx(1));
    CHECK(entry->weights.minCoeff() > -1e-8);
    CHECK(entry->distance == doctest::Approx(entry->normal.dot(outside - entry->position)));
  }
}

TEST_CASE("no segment slips through between two triangles or at a node") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  for (double x = -0.04; x < 0.045; x += 0.005)
    for (double y = -0.03; y < 0.035; y += 0.005) {
      const auto entry = surface.entry(mesh.nodes, {x, y, 0.1}, {x, y, 0});
      REQUIRE(entry);
      CHECK((entry->position - Vector3(x, y, kHalf.z())).norm() < 1e-9);
      CHECK((entry->normal - Vector3::UnitZ()).norm() < 0.9);
    }
}

TEST_CASE("from inside out, short of the surface, beside it and along it there is no entry") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  CHECK_FALSE(surface.entry(mesh.nodes, {0.001, 0.002, 0}, {0.001, 0.002, 0.1}));
  CHECK_FALSE(surface.entry(mesh.nodes, {0.001, 0.002, 0.2}, {0.001, 0.002, 0.061}));
  CHECK_FALSE(surface.entry(mesh.nodes, {0.06, 0, 0.1}, {0.06, 0, -0.1}));
  CHECK_FALSE(surface.entry(mesh.nodes, {0.001, -0.1, 0.061}, {0.001, 0.1, 0.061}));
}

TEST_CASE("the closest point of the surface, from outside and from inside") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  Random random(7);
  for (int repeat = 0; repeat < 300; ++repeat) {
    const Vector3 p = random.vector(0.1);
    const SurfacePoint closest = surface.closest(mesh.nodes, p);
    const Vector3 clamped = p.cwiseMax(-kHalf).cwiseMin(kHalf);
    const double expected = inside_box(p) ? (kHalf - p.cwiseAbs()).minCoeff() : (p - clamped).norm();
    CHECK((closest.position - p).norm() == doctest::Approx(expected).epsilon(1e-9));
    CHECK(closest.normal.norm() == doctest::Approx(1));
    CHECK((closest.distance > 0) == !inside_box(p));
  }
}

TEST_CASE("away from the edges the normal is the face's and the distance its height") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  const SurfacePoint top = surface.closest(mesh.nodes, {0.004, 0.003, 0.09});
  CHECK((top.normal - Vector3::UnitZ()).norm() < 1e-12);
  CHECK(top.distance == doctest::Approx(0.03));
  const SurfacePoint below = surface.closest(mesh.nodes, {0.004, 0.003, 0.055});
  CHECK(below.distance == doctest::Approx(-0.005));
}

TEST_CASE("a surface point is a material point and moves with the tissue") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  const Matrix3X x = deformed(mesh);
  Random random(8);
  for (int repeat = 0; repeat < 100; ++repeat) {
    const SurfacePoint point = surface.closest(x, random.vector(0.5));
    const MaterialPoint material = surface.material(point);
    CHECK((material_position(mesh, x, material) - point.position).norm() < 1e-14);
    const Vector3 at_rest = material_position(mesh, mesh.nodes, material);
    CHECK((kHalf - at_rest.cwiseAbs()).cwiseAbs().minCoeff() < 1e-12);  // still on the box's boundary
  }
}

TEST_CASE("near is a box around the tissue as it stands") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  CHECK(surface.near(mesh.nodes, {0, 0, 0.065}, 0.006));
  CHECK_FALSE(surface.near(mesh.nodes, {0, 0, 0.065}, 0.004));
  const Matrix3X away = mesh.nodes.colwise() + Vector3(1, 0, 0);
  CHECK_FALSE(surface.near(away, {0, 0, 0.065}, 0.006));
  CHECK(surface.near(away, {1, 0, 0}, 0));
}

// Per tetrahedron, 1 for those whose middle lies in the box's part around the origin, 0 for the others.
std::vector<int> core_and_shell(const TetrahedralMesh& mesh) {
  std::vector<int> regions;
  for (const auto& nodes : mesh.tetrahedra) {
    Vector3 middle = Vector3::Zero();
    for (const int node : nodes) middle += mesh.nodes.col(node) / 4;
    regions.push_back((middle.array().abs() < Vector3(0.03, 0.02, 0.04).array()).all() ? 1 : 0);
  }
  return regions;
}

TEST_CASE("the surface of a region is where it meets the others, seen from outside of it") {
  const TetrahedralMesh mesh = box();
  const std::vector<int> regions = core_and_shell(mesh);
  const Surface surface(mesh, regions, 1);
  // The core is a box of 3 x 2 x 4 cells: two triangles for each face of a cell.
  CHECK(surface.triangle_count() == 2 * 2 * (3 * 2 + 2 * 4 + 4 * 3));
  const Vector3 half(0.03, 0.02, 0.04);
  Random random(9);
  for (int repeat = 0; repeat < 200; ++repeat) {
    const Vector3 p = random.vector(0.04);
    const bool inside = (p.array().abs() < half.array()).all();
    const SurfacePoint at = surface.closest(mesh.nodes, p);
    const Vector3 clamped = p.cwiseMax(-half).cwiseMin(half);
    const double expected = inside ? (half - p.cwiseAbs()).minCoeff() : (p - clamped).norm();
    CHECK((at.position - p).norm() == doctest::Approx(expected).epsilon(1e-9));
    CHECK((at.distance > 0) == !inside);
    CHECK(regions[static_cast<std::size_t>(surface.material(at).tetrahedron)] == 0);
    CHECK((material_position(mesh, mesh.nodes, surface.material(at)) - at.position).norm() < 1e-14);
    REQUIRE(surface.beyond(at) >= 0);
    CHECK(regions[static_cast<std::size_t>(surface.beyond(at))] == 1);
    CHECK(barycentric(mesh, mesh.nodes, surface.beyond(at), at.position).minCoeff() > -1e-9);
  }
}

TEST_CASE("seen from the other region, the same faces look the other way") {
  const TetrahedralMesh mesh = box();
  const std::vector<int> regions = core_and_shell(mesh);
  const Surface core(mesh, regions, 1), shell(mesh, regions, 0);
  CHECK(core.triangle_count() == shell.triangle_count());  // the mesh's own boundary is not part of it
  const Vector3 p(0.003, 0.002, 0.045);
  const SurfacePoint of_core = core.closest(mesh.nodes, p), of_shell = shell.closest(mesh.nodes, p);
  CHECK((of_core.normal - Vector3::UnitZ()).norm() < 1e-12);
  CHECK((of_shell.normal + Vector3::UnitZ()).norm() < 1e-12);
  CHECK(of_core.distance == doctest::Approx(0.005));
  CHECK(of_shell.distance == doctest::Approx(-0.005));
}

TEST_CASE("without regions a surface inside is empty, and nothing lies beyond the mesh's own") {
  const TetrahedralMesh mesh = box();
  const Surface none(mesh, {}, 1), boundary(mesh);
  CHECK(none.empty());
  CHECK_FALSE(none.near(mesh.nodes, Vector3::Zero(), 1));
  CHECK_FALSE(none.entry(mesh.nodes, {0.003, 0.002, 0.1}, {0.003, 0.002, 0}));
  CHECK(boundary.beyond(boundary.closest(mesh.nodes, {0.003, 0.002, 0.09})) == -1);
}

TEST_CASE("a trace stops where the region changes, and goes on from there to the next border") {
  const TetrahedralMesh mesh = box();
  const std::vector<int> regions = core_and_shell(mesh);
  const Matrix3X x = deformed(mesh);
  const auto world = [&](const Vector3& p) {
    const int t = tetrahedra_at(mesh, p).front();
    return material_position(mesh, x, {t, barycentric(mesh, mesh.nodes, t, p)});
  };
  Random random(10);
  for (int repeat = 0; repeat < 100; ++repeat) {
    const Vector3 aside(random.uniform(-0.017, 0.017), random.uniform(-0.015, 0.015), 0);
    const Vector3 from = aside + Vector3(0, 0, 0.055), to = aside - Vector3(0, 0, 0.055);
    int start = tetrahedra_at(mesh, from).front(), came_from = -1;
    Vector3 at = from;
    // Down through the shell, the core, and the shell again.
    for (const double border : {0.04, -0.04}) {
      const Trace trace = trace_segment(mesh, x, start, world(at), world(to), regions, came_from);
      CHECK_FALSE(trace.left);
      REQUIRE(trace.next >= 0);
      at = material_position(mesh, mesh.nodes, trace.end);
      CHECK((at - aside - Vector3(0, 0, border)).norm() < 1e-9);
      CHECK(regions[static_cast<std::size_t>(trace.end.tetrahedron)] == (border > 0 ? 0 : 1));
      CHECK(regions[static_cast<std::size_t>(trace.next)] == (border > 0 ? 1 : 0));
      came_from = trace.end.tetrahedron;
      start = trace.next;
    }
    const Trace last = trace_segment(mesh, x, start, world(at), world(to), regions, came_from);
    CHECK(last.next == -1);
    CHECK_FALSE(last.left);
    CHECK((material_position(mesh, mesh.nodes, last.end) - to).norm() < 1e-9);
  }
}

TEST_CASE("a trace within one region pays no heed to regions") {
  const TetrahedralMesh mesh = box();
  const std::vector<int> regions = core_and_shell(mesh);
  const Vector3 from(-0.045, 0.033, 0.051), to(0.045, 0.033, -0.05);
  const Trace trace = trace_segment(mesh, mesh.nodes, tetrahedra_at(mesh, from).front(), from, to, regions);
  CHECK(trace.next == -1);
  CHECK((material_position(mesh, mesh.nodes, trace.end) - to).norm() < 1e-9);
}

}  // namespace
}  // namespace acus
