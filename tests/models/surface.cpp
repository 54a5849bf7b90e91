// SPDX-License-Identifier: GPL-3.0-or-later
// Finding the tissue's surface and walking through its tetrahedra, on a box whose answers are known.
#include "server/engine/models/geometry/surface.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "server/engine/math/random.h"
#include "server/engine/models/geometry/clusters.h"
#include "server/engine/models/geometry/triangle.h"
#include "server/engine/scene/files/mesh_file.h"
#include "tests/support/places.h"

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
      CHECK((entry->normal - Vector3::UnitZ()).norm() < 1e-9);
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
  CHECK(below.distance == doctest::Approx(-0.005).epsilon(1e-9).scale(0));
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
  CHECK((of_core.position - Vector3(0.003, 0.002, 0.04)).norm() < 1e-12);
  CHECK((of_core.position - of_shell.position).norm() < 1e-12);
  CHECK((of_core.normal + of_shell.normal).norm() < 1e-12);
  CHECK(of_core.distance == doctest::Approx(0.005 * of_core.normal.z()).epsilon(1e-9).scale(0));
  CHECK(of_shell.distance == doctest::Approx(-of_core.distance).epsilon(1e-9).scale(0));
}

TEST_CASE("inside no edge is sharp: along a border the normal turns bit by bit") {
  const TetrahedralMesh mesh = box();
  const Surface core(mesh, core_and_shell(mesh), 1);
  // From the middle of the top over an edge to the middle of a side.
  const auto place = [](double s) { return s < 0.02 ? Vector3(0.003, s, 0.04) : Vector3(0.003, 0.02, 0.06 - s); };
  constexpr double kStep = 1e-4;
  Vector3 before = core.closest(mesh.nodes, place(0)).normal;
  CHECK(before.z() > 0.99);
  for (double s = kStep; s < 0.06; s += kStep) {
    const Vector3 normal = core.closest(mesh.nodes, place(s)).normal;
    CHECK((normal - before).norm() < 0.02);
    before = normal;
  }
  CHECK(before.y() > 0.99);
}

// Largest difference of the normals of two triangles in the middle of an edge that they share, at most 40 degrees sharp
// at rest.
double largest_turn_at_edges(const TetrahedralMesh& mesh, const Matrix3X& x) {
  const Surface surface(mesh);
  const auto weights = [&](std::size_t t, int a, int b) {
    Eigen::Vector3d w;
    for (int k = 0; k < 3; ++k) w[k] = mesh.surface[t][k] == a || mesh.surface[t][k] == b ? 0.5 : 0;
    return w;
  };
  const auto facing = [&](std::size_t t) {
    const Vector3 a = mesh.nodes.col(mesh.surface[t][0]);
    return Vector3((mesh.nodes.col(mesh.surface[t][1]) - a).cross(mesh.nodes.col(mesh.surface[t][2]) - a).normalized());
  };
  double most = 0;
  for (std::size_t s = 0; s < mesh.surface.size(); ++s)
    for (std::size_t t = 0; t < s; ++t) {
      std::vector<int> shared;
      for (const int node : mesh.surface[s])
        if (std::ranges::count(mesh.surface[t], node) > 0) shared.push_back(node);
      if (shared.size() != 2 || facing(s).dot(facing(t)) < std::cos(0.7)) continue;
      const auto normal = [&](std::size_t u) {
        return surface.normal(x, {.triangle = static_cast<int>(u), .weights = weights(u, shared[0], shared[1])});
      };
      most = std::max(most, (normal(s) - normal(t)).norm());
    }
  return most;
}

TEST_CASE("normals are the same on both sides of every shallow edge, on any mesh, however the tissue stands") {
  Random random(14);
  const TetrahedralMesh organ = read_mesh_file(source_path("scenes/meshes/inclusion.msh"), 1);
  TetrahedralMesh bumpy = make_box_mesh(2 * kHalf, {5, 4, 6});
  bumpy.nodes += random.matrix(3, bumpy.nodes.cols(), 0.004);  // edges of all angles
  for (const TetrahedralMesh& mesh : {organ, bumpy}) {
    const double size = (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).maxCoeff();
    for (const double noise : {0.0, 0.01, 0.05})
      CHECK(largest_turn_at_edges(mesh, mesh.nodes + random.matrix(3, mesh.nodes.cols(), noise * size)) < 1e-12);
  }
}

TEST_CASE("the faces of a box are flat up to its edges, however it is bent") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  const SurfacePoint at_edge = surface.closest(mesh.nodes, {0.0499, 0.003, 0.07});
  CHECK((at_edge.normal - Vector3::UnitZ()).norm() < 1e-12);
  // Sheared until that edge has 30 degrees only: it stays an edge.
  Matrix3 f = Matrix3::Identity();
  f(0, 2) = -std::tan(std::numbers::pi / 3);
  const Matrix3X sheared = f * mesh.nodes;
  CHECK((surface.normal(sheared, at_edge) - Vector3::UnitZ()).norm() < 1e-12);
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

// ---------------------------------------------------------------------- the same answers as a look at every element

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// What the queries of a Surface must answer, bit for bit: every triangle is looked at, one after the other.
struct LinearSurface {
  const TetrahedralMesh& mesh;
  const Matrix3X& x;

  std::array<Vector3, 3> corners(int t) const {
    const auto& nodes = mesh.surface[static_cast<std::size_t>(t)];
    return {x.col(nodes[0]), x.col(nodes[1]), x.col(nodes[2])};
  }

  std::pair<int, Eigen::Vector3d> closest(const Vector3& p) const {
    std::pair<int, Eigen::Vector3d> found{0, {1, 0, 0}};
    double best = std::numeric_limits<double>::infinity();
    for (int t = 0; t < static_cast<int>(mesh.surface.size()); ++t) {
      const auto [a, b, c] = corners(t);
      const TrianglePoint point = closest_on_triangle(p, a, b, c);
      if (!(point.distance2 < best)) continue;
      best = point.distance2;
      found = {t, point.weights};
    }
    return found;
  }

  std::pair<int, Eigen::Vector3d> entry(const Vector3& from, const Vector3& to) const {
    std::pair<int, Eigen::Vector3d> found{-1, {0, 0, 0}};
    double first = std::numeric_limits<double>::infinity();
    for (int t = 0; t < static_cast<int>(mesh.surface.size()); ++t) {
      const auto [a, b, c] = corners(t);
      const auto crossing = cross_triangle(from, to - from, a, b, c);
      if (!crossing || !(crossing->s < first)) continue;
      first = crossing->s;
      found = {t, crossing->weights};
    }
    return found;
  }

  bool near(const Vector3& p, double margin) const {
    Vector3 low = Vector3::Constant(kNan), high = low;
    for (const auto& triangle : mesh.surface)
      for (const int node : triangle)
        for (int k = 0; k < 3; ++k) {
          low[k] = std::fmin(low[k], x(k, node));  // of a number and what is none, the number
          high[k] = std::fmax(high[k], x(k, node));
        }
    return (p.array() >= low.array() - margin).all() && (p.array() <= high.array() + margin).all();
  }

  int find(const Vector3& p) const {
    for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
      const auto& n = mesh.tetrahedra[static_cast<std::size_t>(t)];
      Eigen::Matrix<double, 3, 4> c;
      for (int k = 0; k < 4; ++k) c.col(k) = x.col(n[static_cast<std::size_t>(k)]);
      if (!p.allFinite() || !c.allFinite()) continue;
      if ((p.array() < c.rowwise().minCoeff().array()).any() || (p.array() > c.rowwise().maxCoeff().array()).any())
        continue;
      const Vector3 origin = c.col(0), e1 = c.col(1) - origin, e2 = c.col(2) - origin, e3 = c.col(3) - origin;
      if (e1.dot(e2.cross(e3)) > 0 && barycentric(mesh, x, t, p).minCoeff() >= 0) return t;
    }
    return -1;
  }
};

void check_queries(const Surface& surface, const LinearSurface& linear, const Vector3& p, const Vector3& q) {
  CAPTURE(p.transpose());
  CAPTURE(q.transpose());
  const SurfacePoint closest = surface.closest(linear.x, p);
  CHECK(std::pair(closest.triangle, closest.weights) == linear.closest(p));
  const auto entry = surface.entry(linear.x, p, q);
  const auto expected = linear.entry(p, q);
  REQUIRE(entry.has_value() == (expected.first >= 0));
  if (entry) CHECK(std::pair(entry->triangle, entry->weights) == expected);
  for (const double margin : {0.0, 0.004}) CHECK(surface.near(linear.x, p, margin) == linear.near(p, margin));
  CHECK(find_tetrahedron(linear.mesh, linear.x, p) == linear.find(p));
}

// Points where rounding and ties decide, and points anywhere.
Vector3 telling_point(Random& random, const LinearSurface& linear) {
  const auto node = [&] { return Vector3(linear.x.col(random.index(linear.mesh.node_count()))); };
  const auto [a, b, c] = linear.corners(random.index(static_cast<int>(linear.mesh.surface.size())));
  const Vector3 middle = linear.x.rowwise().mean();
  switch (random.index(8)) {
    case 0:
      return node();
    case 1:
      return (node() + node()) / 2;
    case 2:
      return (a + b) / 2;
    case 3:
      return (a + b + c) / 3;
    case 4:
      return (a + b + c) / 3 + random.vector(1e-3);
    case 5:
      return middle;
    case 6:
      return middle + 100 * random.direction();
    default:
      return middle + random.vector(0.08);
  }
}

void check_telling_points(const TetrahedralMesh& mesh, const Matrix3X& x, Random& random, int points) {
  const Surface surface(mesh);
  const LinearSurface linear{mesh, x};
  for (int i = 0; i < points; ++i)
    check_queries(surface, linear, telling_point(random, linear), telling_point(random, linear));
}

// Ways to stand that tissue takes, and some that it never should.
std::vector<Matrix3X> configurations(const TetrahedralMesh& mesh, Random& random) {
  const Matrix3X& rest = mesh.nodes;
  const double size = (rest.rowwise().maxCoeff() - rest.rowwise().minCoeff()).maxCoeff();
  std::vector<Matrix3X> all{rest, deformed(mesh)};
  for (const double noise : {0.01, 0.3})  // wrinkled; folded, with inverted tetrahedra
    all.push_back(rest + random.matrix(3, rest.cols(), noise * size));
  Matrix3X bent = rest, folded = rest;
  for (int i = 0; i < mesh.node_count(); ++i) {
    bent.col(i) = rotation_exp({30 * rest(2, i), 0, 0}) * Vector3(rest.col(i));
    folded(0, i) = std::abs(rest(0, i));
  }
  all.push_back(bent);
  all.push_back(folded);
  all.push_back(-rest);                                 // inside out
  all.push_back(Vector3(1, 1, 0).asDiagonal() * rest);  // flat
  all.push_back(Vector3(1, 1, 1e-13).asDiagonal() * rest);
  all.push_back(Vector3(1, 1e-12, 1e-12).asDiagonal() * deformed(mesh));  // nearly a line
  all.push_back(Vector3(1, 0, 0) * Eigen::RowVectorXd(rest.row(0)));      // a line
  all.push_back(Matrix3X::Zero(3, rest.cols()));                          // a point
  return all;
}

TEST_CASE("queries answer as a look at every triangle and tetrahedron does, however the tissue stands") {
  Random random(11);
  for (const std::array<int, 3>& cells : {std::array{1, 1, 1}, {2, 1, 3}, {5, 4, 6}, {11, 11, 11}}) {
    const TetrahedralMesh mesh = make_box_mesh(2 * kHalf, cells);
    for (const Matrix3X& x : configurations(mesh, random)) check_telling_points(mesh, x, random, 40);
  }
}

TEST_CASE("queries answer so on a mesh of irregular tetrahedra") {
  const TetrahedralMesh mesh = read_mesh_file(source_path("scenes/meshes/inclusion.msh"), 1);
  Random random(12);
  for (const Matrix3X& x : configurations(mesh, random)) check_telling_points(mesh, x, random, 40);
}

TEST_CASE("more triangles than one batch of boxes holds") {
  const TetrahedralMesh mesh = make_box_mesh(2 * kHalf, {30, 30, 30});
  REQUIRE(mesh.surface.size() > 512 * 16);
  Random random(13);
  check_telling_points(mesh, mesh.nodes, random, 20);
  check_telling_points(mesh, deformed(mesh), random, 20);
}

TEST_CASE("nodes and points that are not numbers, or are infinite or huge, are left out and harm no other answer") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  Random random(14);
  for (const double bad :
       {kNan, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), 1e200, -1e308}) {
    CAPTURE(bad);
    Matrix3X x = deformed(mesh);
    for (int broken = 0; broken < 12; ++broken) {
      for (int i = 0; i < 10; ++i) {
        const LinearSurface linear{mesh, x};
        Vector3 p = telling_point(random, {mesh, mesh.nodes}), q = telling_point(random, {mesh, mesh.nodes});
        check_queries(surface, linear, p, q);
        p[random.index(3)] = bad;
        check_queries(surface, linear, p, q);
        check_queries(surface, linear, q, p);
      }
      x(random.index(3), broken < 6 ? random.index(mesh.node_count()) : mesh.surface[0][broken % 3]) = bad;
    }
    x.setConstant(bad);
    check_queries(surface, {mesh, x}, Vector3::Zero(), Vector3::UnitX());
  }
  const Matrix3X nowhere = Matrix3X::Constant(3, mesh.node_count(), kNan);
  CHECK(surface.closest(nowhere, Vector3::Zero()).triangle == 0);
  CHECK_FALSE(surface.entry(nowhere, Vector3::Zero(), Vector3::UnitX()));
  CHECK_FALSE(surface.near(nowhere, Vector3::Zero(), 1));
  CHECK(find_tetrahedron(mesh, nowhere, Vector3::Zero()) == -1);
  CHECK(find_tetrahedron(mesh, mesh.nodes, Vector3(0, kNan, 0)) == -1);
}

TEST_CASE("of triangles that are as close, or crossed at once, the first counts") {
  const TetrahedralMesh mesh = box();
  const Surface surface(mesh);
  // The middle is as far from the centres of two faces; at a node the triangles around it tie.
  CHECK(surface.closest(mesh.nodes, Vector3::Zero()).distance == doctest::Approx(-kHalf.y()));
  for (const auto& triangle : mesh.surface)
    for (const int node : triangle) {
      const Vector3 p = mesh.nodes.col(node);
      int first = 0;
      while (std::ranges::count(mesh.surface[static_cast<std::size_t>(first)], node) == 0) ++first;
      CHECK(surface.closest(mesh.nodes, p).triangle == first);
    }
}

TEST_CASE("the closest point of a triangle lies in it, however thin it is") {
  Random random(15);
  for (int repeat = 0; repeat < 20000; ++repeat) {
    const Vector3 a = random.vector(), way = random.direction(), p = random.vector(2);
    const double height = std::pow(10.0, random.uniform(-20, 0));
    const Vector3 b = a + random.uniform(-1, 1) * way + random.vector(height);
    const Vector3 c = a + random.uniform(-1, 1) * way + random.vector(height);
    const TrianglePoint point = closest_on_triangle(p, a, b, c);
    CHECK(point.weights.minCoeff() >= 0);
    CHECK(point.weights.sum() == doctest::Approx(1).epsilon(1e-15));
    if (height < 1e-6) continue;  // thinner ones may answer with another of their points
    const double corner2 = std::min({(p - a).squaredNorm(), (p - b).squaredNorm(), (p - c).squaredNorm()});
    CHECK(point.distance2 <= doctest::Approx(corner2));
  }
}

TEST_CASE("clusters hold every element once, all of their nodes, and neighbours") {
  const TetrahedralMesh mesh = make_box_mesh(2 * kHalf, {10, 8, 12});
  const Clusters clusters(mesh.nodes, mesh.surface, 16);
  std::vector<int> elements;
  double area = 0;  // of the clusters' boxes
  for (int i = 0; i < clusters.count(); ++i) {
    CHECK(clusters.elements(i).size() <= 16);
    CHECK(std::ranges::is_sorted(clusters.elements(i)));
    elements.insert(elements.end(), clusters.elements(i).begin(), clusters.elements(i).end());
    const Bounds box = clusters.bounds(mesh.nodes, i);
    for (const int t : clusters.elements(i))
      for (const int node : mesh.surface[static_cast<std::size_t>(t)]) {
        CHECK(std::ranges::count(clusters.nodes(i), node) == 1);
        CHECK(box.contains(mesh.nodes.col(node)));
      }
    const Vector3 d = box.high - box.low;
    area += 2 * (d.x() * d.y() + d.y() * d.z() + d.z() * d.x());
  }
  CHECK(clusters.count() == (mesh.surface.size() + 15) / 16);
  std::ranges::sort(elements);
  for (int t = 0; t < static_cast<int>(mesh.surface.size()); ++t) CHECK(elements[static_cast<std::size_t>(t)] == t);
  // Both sides of the box's faces would be 2; clusters that bend around its edges, and overlap, have more.
  const double surface = 8 * (kHalf.x() * kHalf.y() + kHalf.y() * kHalf.z() + kHalf.z() * kHalf.x());
  CHECK(area < 4 * surface);
}

}  // namespace
}  // namespace acus
