// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/contact/contact_patch.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace acus {

namespace {

// Of a disc of radius 1: x, y of the middles of kPatchPoints shares of equal area, in rings.
std::array<Eigen::Vector2d, kPatchPoints> make_unit_disc() {
  constexpr std::array kInRing{1, 8, 12};  // a mirrored mesh gives the mirrored patch
  std::array<Eigen::Vector2d, kPatchPoints> disc;
  std::size_t next = 0;
  for (const int count : kInRing) {
    const double inside = static_cast<double>(next);  // shares within the ring
    const double radius = count == 1 ? 0 : std::sqrt((inside + count / 2.0) / kPatchPoints);
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * std::numbers::pi * k / count;
      disc[next++] = radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
  }
  return disc;
}

}  // namespace

ContactPatch make_contact_patch(const TissueView& tissue, const Surface& surface, const MaterialPoint& centre,
                                double radius, double width) {
  assert(radius > 0 && radius < kInfinity);
  static const std::array<Eigen::Vector2d, kPatchPoints> kDisc = make_unit_disc();
  const Matrix3X& rest = tissue.mesh.nodes;
  const Vector3 at = material_position(tissue.mesh, rest, centre);
  const SurfacePoint in_the_middle = surface.closest(rest, at);
  const Vector3 upwards = surface.mean_normal(rest, in_the_middle, width);
  Vector3 across[2];
  perpendicular_basis(tissue.mesh, upwards, across[0], across[1]);
  ContactPatch patch;
  double sum = 0;
  Vector3 normal_now = Vector3::Zero(), normal_at_rest = Vector3::Zero();
  for (std::size_t i = 0; i < kDisc.size(); ++i) {
    const Vector3 on_disc = at + radius * (kDisc[i].x() * across[0] + kDisc[i].y() * across[1]);
    const SurfacePoint point = i == 0 ? in_the_middle : surface.closest_facing(rest, on_disc, upwards);
    const double way = 4 * (point.position - on_disc).norm() / radius;
    const double share = 1 / ((1 + way * way) * (1 + way * way));
    patch.points[i] = i == 0 ? centre : surface.material(point);
    patch.points[i].weights *= share;
    normal_now += share * surface.normal(tissue.x_start, point);
    normal_at_rest += share * point.normal;
    sum += share;
  }
  for (MaterialPoint& point : patch.points) point.weights /= sum;
  const Vector3 stands = width > 0 ? upwards : normal_at_rest.stableNormalized();
  patch.normal = (stands + (normal_now - normal_at_rest) / sum).stableNormalized();
  patch.middle = mean_position(tissue.mesh, tissue.x_start, patch.points);
  patch.rise = stands.dot(at - mean_position(tissue.mesh, rest, patch.points));
  return patch;
}

bool is_crushed(const TetrahedralMesh& mesh, const Matrix3X& x, std::span<const MaterialPoint> points) {
  return std::ranges::any_of(points, [&](const MaterialPoint& point) {
    return signed_volume(x, mesh.tetrahedra[static_cast<std::size_t>(point.tetrahedron)]) <= 0;
  });
}

Vector3 mean_position(const TetrahedralMesh& mesh, const Matrix3X& x, std::span<const MaterialPoint> points) {
  Vector3 sum = Vector3::Zero();
  for (const MaterialPoint& point : points) sum += material_position(mesh, x, point);
  return sum;
}

}  // namespace acus
