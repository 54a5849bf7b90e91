// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tick/insertion/bench_insertion.h"

#include "server/engine/math/rotation.h"
#include "server/engine/state/needle/phase.h"
#include "server/engine/tick/insertion/finding/tip_place.h"

namespace acus::test {

namespace {

constexpr int kPaths = 3;

Pose base_of(const Vector3& tip, const Vector3& along, double spin) {
  Pose base;
  base.orientation = rotation_exp(spin * along) * rotation_between(Vector3::UnitX(), along);
  base.position = tip - kLength * along;
  return base;
}

std::vector<Interaction> interactions_of(const Scene& scene) {
  std::vector<Interaction> all;
  for (const Region& region : scene.tissue.regions) all.push_back(region.interaction);
  return all;
}

}  // namespace

Scene one_region() {
  Scene scene;
  scene.tissue.box.size = Vector3::Constant(kTop - kBottom);
  scene.tissue.box.cells = {6, 6, 6};
  Interaction& law = scene.tissue.regions[0].interaction;
  law = {.puncture_force = 0.4, .cutting_force = 0.2, .pressure = 6e3, .foundation_stiffness = 50e3};
  law.friction_static = 0.35;
  law.friction_dynamic = 0.3;
  scene.needles[0].length = kLength;
  scene.needles[0].beams = 10;
  scene.needles[0].outer_diameter = kDiameter;
  return scene;
}

Scene two_regions(double puncture_force) {
  Scene scene = one_region();
  Region lower = scene.tissue.regions[kUpper];
  scene.tissue.regions[kUpper].name = "upper";
  lower.name = "lower";
  lower.half_space = HalfSpace{Vector3::Zero(), Vector3::UnitZ()};
  lower.interaction.puncture_force = puncture_force;
  scene.tissue.regions.push_back(lower);
  return scene;
}

InsertionBench::InsertionBench(const Scene& from, int path_vertices)
    : scene(from),
      mesh(load_mesh(scene)),
      regions(assign_regions(scene, mesh)),
      interactions(interactions_of(scene)),
      element_sizes(static_cast<std::size_t>(mesh.tetrahedron_count()), 0.01),
      surface(mesh),
      borders(scene.tissue, mesh, regions),
      x(mesh.nodes),
      parameters(scene.needles[0]),
      model(make_needle_model(parameters, Vector3::Zero(), true)),
      paths(kPaths, Path(path_vertices)),
      paths_taken(kPaths, 0),
      state(make_insertion(path_vertices, shaft_cells(parameters))),
      scratch(max_shaft_points(parameters, least_spacing(scene.needles)), path_vertices, shaft_cells(parameters)) {
  events.reserve(100);
  put_needle(on_line(0.1));
}

void InsertionBench::put_needle(const Vector3& tip, const Vector3& along) {
  put_shape(make_needle_state(model, base_of(tip, along, 0)), start);
  shape = start;
}

void InsertionBench::move_needle(const Vector3& tip, const Vector3& along, double spin) {
  put_shape(make_needle_state(model, base_of(tip, along, spin)), shape);
}

MaterialPoint InsertionBench::point(const Vector3& p) const {
  MaterialPoint best;
  double most = -kInfinity;  // a point on a face is outside by rounding
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    const Eigen::Vector4d weights = barycentric(mesh, x, t, p);
    if (weights.minCoeff() <= most) continue;
    most = weights.minCoeff();
    best = {t, weights};
  }
  return best;
}

MaterialPoint InsertionBench::border_point(int region, const Vector3& p) const {
  const Surface& border = borders.surface(region);
  return border.material(border.closest(x, p));
}

Path& InsertionBench::add_path(const std::vector<Vector3>& places, double spacing) {
  std::size_t i = 0;
  while (!paths[i].empty()) ++i;
  Path& path = paths[i];
  path.begin(point(places.front()), spacing);
  for (std::size_t k = 1; k + 1 < places.size(); ++k) path.vertices.push_back(point(places[k]));
  path.end = point(places.back());
  path.tail = (places.back() - places[places.size() - 2]).norm();
  return path;
}

Path& InsertionBench::add_straight_path(double z, double spacing) {
  std::vector<Vector3> places;
  for (int i = 0; kTop - i * spacing > z + kRounding; ++i) places.push_back(on_line(kTop - i * spacing));
  places.push_back(on_line(z));
  return add_path(places, spacing);
}

InsertionView InsertionBench::view() const {
  return {0, parameters, NeedleView{model, start, shape, kH},
          TissueView{mesh, surface, borders, scene.tissue.regions, interactions, element_sizes, regions, x, x,
                     scene.tissue.local_compliance == LocalCompliance::all},
          parameters.cutting_direction.normalized()};
}

double InsertionBench::give() const {
  const TissueView tissue = view().tissue;
  const MaterialPoint anywhere = point(on_line(kTop));
  const double cutting_force = tissue.interaction(anywhere).cutting_force;
  return cutting_force * tissue.tip_compliance(anywhere, kDiameter, cutting_force);
}

const Located& InsertionBench::locate() {
  locate_insertion(view(), state, paths, paths_taken, scratch);
  return scratch.located;
}

void InsertionBench::be_in_path(int path) {
  enter(state, path, kLength);
  paths[static_cast<std::size_t>(path)].needle = 0;
}

std::vector<EventKind> InsertionBench::event_kinds() const {
  std::vector<EventKind> kinds;
  for (const Event& event : events) kinds.push_back(event.kind);
  return kinds;
}

}  // namespace acus::test
