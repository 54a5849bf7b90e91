// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "server/simulation/base_motion.h"
#include "server/simulation/borders.h"
#include "server/simulation/guide_hold.h"
#include "server/simulation/insertion.h"
#include "server/scene/scene_error.h"

namespace acus {

namespace {

constexpr int kMaxPaths = 64;
constexpr int kMaxRepeats = 10;     // of a step that rungs without iterations make once, but for one that goes too far
constexpr int kLookEvery = 8;       // ticks, while all that lies ahead is ready
constexpr int kStepsAhead = 6;      // of a look for the tetrahedra that a tip will enter
constexpr double kStepAhead = 0.3;  // sizes of the tip's element
constexpr int kOtherEvents = 8;  // of one needle in one tick, besides the borders that it crosses

// The scene itself, if its values are in range: one built in code has not been through the reader.
const Scene& checked(const Scene& scene) {
  validate(scene);
  return scene;
}

std::vector<Interaction> interactions_of(const Scene& scene) {
  std::vector<Interaction> all;
  for (const Region& region : scene.tissue.regions) {
    all.push_back(region.interaction);
    all.back().pressure = shaft_pressure(region);
  }
  return all;
}

std::vector<Material> materials_of(const Scene& scene) {
  std::vector<Material> all;
  for (const Region& region : scene.tissue.regions) all.push_back(region.material);
  return all;
}

// The edges of regular tetrahedra of the same volumes (m).
std::vector<double> element_sizes_of(const TetrahedralMesh& mesh) {
  std::vector<double> sizes;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    sizes.push_back(std::cbrt(6 * std::numbers::sqrt2 * rest_volume(mesh, t)));
  return sizes;
}

TissueMatrix matrix_of(TissueRung rung) {
  switch (rung) {
    case TissueRung::linear:
      return TissueMatrix::constant;
    case TissueRung::exact:
      return TissueMatrix::refactorized;
    default:
      return TissueMatrix::turned;
  }
}

template <class Value>
int sum_over_needles(const Scene& scene, Value value) {
  int sum = 0;
  for (const Needle& needle : scene.needles) sum += value(needle);
  return sum;
}

// Rows of the laws in one tick, at most: between a needle and the tissue, of all guides, and all together.
int max_tissue_rows(const Scene& scene, const Needle& needle) {
  return scene.tissue.left_out() ? 0 : Insertion::max_rows(needle);
}

int max_guide_rows(const Scene& scene) { return GuideHold::kMaxRows * static_cast<int>(scene.guides.size()); }

int max_rows(const Scene& scene) {
  return sum_over_needles(scene, [&](const Needle& needle) { return max_tissue_rows(scene, needle); }) +
         max_guide_rows(scene);
}

int find_needle(const Scene& scene, const std::string& name) {
  const auto same = [&](const Needle& needle) { return needle.name == name; };
  return static_cast<int>(std::find_if(scene.needles.begin(), scene.needles.end(), same) - scene.needles.begin());
}

// Vertices that a path can hold: any needle may pick it up.
int vertices_per_path(const Scene& scene) {
  if (scene.tissue.left_out()) return 0;
  int most = 0;
  for (const Needle& needle : scene.needles) most = std::max(most, 2 * Insertion::max_points(needle));
  return most;
}

// Tells what a step of loading is about to make, and makes it.
template <class Make>
auto announced(const Progress& progress, const char* what, Make make) {
  if (progress) progress(what);
  return make();
}

// Adds the time since its construction or the last lap() to a stage, if timing is on.
class StageTimer {
 public:
  StageTimer(bool on, std::array<double, kStageCount>& seconds) : on_(on), seconds_(seconds) {
    if (on_) {
      seconds_.fill(0);
      last_ = Clock::now();
    }
  }
  void lap(int stage) {
    if (!on_) return;
    const Clock::time_point now = Clock::now();
    seconds_[stage - 1] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  bool on_;
  std::array<double, kStageCount>& seconds_;
  Clock::time_point last_;
};

}  // namespace

struct Simulation::World {
  World(const Scene& s, const Progress& progress);

  // The stages, in the order of a tick.
  void take_commands();
  bool needle_free_motion();
  bool tissue_free_motion();
  void locate();
  bool build_rows();
  void compute_compliance();
  SolverResult solve_laws();
  double correct();
  void read_forces();
  void commit();
  void hold();
  std::uint32_t transitions();
  void look_ahead();
  void write_report(std::uint32_t flags, const SolverResult& laws, int iterations);

  NeedleView needle_view(int i) const { return {needle_models[i], start_shapes[i], motions[i].shape(), h}; }
  TissueView tissue_view() const {
    return {mesh, surface, borders, scene.tissue.regions, interactions,
            element_sizes, regions, tissue.x, tissue_motion.x(), scene.tissue.local_compliance};
  }
  int needles() const { return static_cast<int>(scene.needles.size()); }
  bool iterates() const { return scene.tissue.rung == TissueRung::refined || scene.tissue.rung == TissueRung::exact; }
  bool finite() const;
  void reset();
  int max_sweeps() const { return economized(scene.laws.max_sweeps, scene.overrun.max_sweeps); }
  int uncapped_iterations() const { return iterates() ? scene.newton.max_iterations : kMaxRepeats; }
  int max_iterations() const { return economized(uncapped_iterations(), scene.overrun.max_iterations); }
  bool went_too_far() const;
  int economized(int limit, int lower) const { return economizing ? std::min(limit, lower) : limit; }
  void balance_of_forces();
  double potential_energy() const;
  Energy energy();
  void refuse_tip_inside(int needle) const;

  // Constant after load.
  Scene scene;
  double h;
  TetrahedralMesh mesh;
  std::vector<int> regions;
  std::vector<Interaction> interactions;
  std::vector<double> element_sizes;  // m
  TissueModel tissue_model;
  std::vector<NeedleModel> needle_models;
  Surface surface;
  Borders borders;

  // State.
  std::uint64_t tick = 0;
  TissueState tissue;
  std::vector<NeedleState> needle_states;
  std::vector<BaseMotion> bases;
  std::vector<Insertion> insertions;
  std::vector<GuideHold> guides;
  std::vector<Path> paths;

  // Work of a tick.
  std::vector<Pose> base_poses;
  std::vector<NeedleShape> start_shapes;
  std::vector<NeedleMotion> motions;
  TissueMotion tissue_motion;
  Rows rows;
  double step_share = 1;                 // of the last correction, that bodies went
  std::vector<std::uint64_t> next_look;  // per needle, the tick of its next look_ahead()
  double potential_at_start = 0;             // J
  Vector3 needle_balance = Vector3::Zero();  // last tick: base forces + weight - inertia of all needles (N)
  double needle_largest_force = 0;
  bool timing = false;
  bool economizing = false;
  TickReport report;
};

Simulation::World::World(const Scene& s, const Progress& progress)
    : scene(checked(s)),
      h(1 / s.rate),
      mesh(announced(progress, "mesh", [&] { return load_mesh(s); })),
      regions(announced(progress, "regions", [&] { return assign_regions(s, mesh); })),
      interactions(interactions_of(s)),
      element_sizes(element_sizes_of(mesh)),
      tissue_model(announced(progress, "elements", [&] {
        return make_tissue_model(mesh, regions, materials_of(s), find_fixed_nodes(s, mesh), s.gravity,
                                 s.tissue.element);
      })),
      surface(announced(progress, "surfaces", [&] { return Surface(mesh); })),
      borders(s.tissue, mesh, regions),
      tissue_motion(announced(progress, "factor", [&] {
        return TissueMotion(tissue_model, h, matrix_of(s.tissue.rung), max_rows(s),
                            4 * sum_over_needles(s, Insertion::max_material_points));
      })),
      rows(announced(progress, "rows", [&] { return Rows(max_rows(s)); })) {
  if (progress) progress("needles");
  const int vertices = vertices_per_path(scene);
  needle_models.reserve(scene.needles.size());
  for (int i = 0; i < needles(); ++i) {
    const Needle& needle = scene.needles[i];
    needle_models.push_back(make_needle_model(needle, scene.gravity, needle.rung == NeedleRung::rigid));
    bases.emplace_back(needle, h);
    insertions.emplace_back(i, needle, vertices);
    motions.emplace_back(needle_models[i], h, max_tissue_rows(scene, needle) + max_guide_rows(scene));
    start_shapes.push_back(motions[i].shape());
    needle_states.push_back(make_needle_state(needle_models[i], needle.base));
    base_poses.push_back(needle.base);
  }
  for (int i = 0; i < static_cast<int>(scene.guides.size()); ++i)
    guides.emplace_back(i, find_needle(scene, scene.guides[i].needle), scene.guides[i], h);
  for (int i = 0; i < needles(); ++i) refuse_tip_inside(i);
  paths.resize(kMaxPaths);
  for (Path& path : paths) path.vertices.reserve(static_cast<std::size_t>(vertices));
  report.needles.resize(scene.needles.size());
  report.events.reserve((Insertion::kMaxCrossings + kOtherEvents) * scene.needles.size());
  reset();
}

// A tip in the middle of the tissue has no path that it came by.
void Simulation::World::refuse_tip_inside(int needle) const {
  const Vector3 tip = needle_states[needle].x.rightCols<1>();
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    if (barycentric(mesh, mesh.nodes, t, tip).minCoeff() < 0) continue;
    throw scene_error(scene, child_path("needles", static_cast<std::size_t>(needle)) + ".base",
                      "expected the needle's tip outside the tissue, found it inside; move the base back");
  }
}

void Simulation::World::reset() {
  tick = 0;
  tissue.x = mesh.nodes;
  tissue.v.setZero(3, mesh.node_count());
  tissue_motion.reset();
  for (Path& path : paths) {
    path.vertices.clear();
    path.needle = -1;
    path.left = 0;
  }
  for (int i = 0; i < needles(); ++i) {
    bases[i].reset();
    insertions[i].reset();
    needle_states[i] = make_needle_state(needle_models[i], scene.needles[i].base);
    motions[i].begin(needle_states[i], scene.needles[i].base);
  }
  for (GuideHold& guide : guides) guide.reset();
  rows.clear();
  potential_at_start = potential_energy();
  economizing = false;
  next_look.assign(scene.needles.size(), 0);
  needle_balance.setZero();
  needle_largest_force = 0;
  report.tick = 0;
  report.time = 0;
  report.flags = 0;
  report.imbalance = report.largest_force = report.residual = 0;
  report.rows = report.sweeps = report.newton_iterations = 0;
  report.solver = LawMethod::gauss_seidel;
  report.stage_seconds.fill(0);
  report.events.clear();
  for (int i = 0; i < needles(); ++i) {
    report.needles[i] = NeedleReport{};
    report.needles[i].base = scene.needles[i].base;
    report.needles[i].tip_position = needle_states[i].x.rightCols<1>();
  }
}

// 1. Newest pose and spin of every base and guide, followed within the speed limits.
void Simulation::World::take_commands() {
  ++tick;
  for (GuideHold& guide : guides) guide.advance(tick);
  for (int i = 0; i < needles(); ++i) base_poses[i] = bases[i].advance(tick);
  for (int i = 0; i < needles(); ++i) {
    start_shapes[i] = motions[i].shape();
    motions[i].begin(needle_states[i], base_poses[i]);
  }
  tissue_motion.begin(tissue);
}

// 2. Block-tridiagonal factor and free motion of every needle.
bool Simulation::World::needle_free_motion() {
  bool exact = true;
  for (int i = 0; i < needles(); ++i) exact = motions[i].linearize(needle_states[i]) && exact;
  return exact;
}

// 3. Element forces and one forward substitution.
bool Simulation::World::tissue_free_motion() { return tissue_motion.linearize(tissue); }

// 4. Tip and path points against needle and tissue.
void Simulation::World::locate() {
  for (int i = 0; i < needles(); ++i) insertions[i].locate(needle_view(i), tissue_view(), paths);
  for (GuideHold& guide : guides) guide.locate(needle_view(guide.needle()));
}

// 5. Directions, gaps and laws.
bool Simulation::World::build_rows() {
  rows.clear();
  bool all = true;
  for (int i = 0; i < needles(); ++i)
    all = insertions[i].build_rows(needle_view(i), tissue_view(), paths, rows) && all;
  for (const GuideHold& guide : guides) all = guide.build_rows(needle_view(guide.needle()), rows) && all;
  return all;
}

// 6. W and delta_free.
void Simulation::World::compute_compliance() { rows.assemble(motions, tissue_motion); }

// 7. lambda.
SolverResult Simulation::World::solve_laws() {
  return rows.solve(scene.laws.solver, max_sweeps(), scene.laws.tolerance);
}

// 8. Free motion and the rows' forces together; returns the largest change of a position (m).
double Simulation::World::correct() {
  tissue_motion.solve(rows.lambda());
  for (int i = 0; i < needles(); ++i) motions[i].solve(rows.needle_forces(i));
  // All bodies by the same share, so that action stays equal to reaction in work, too.
  step_share = tissue_motion.trusted_share();
  for (int i = 0; i < needles(); ++i) step_share = std::min(step_share, motions[i].trusted_share(needle_states[i]));
  double change = tissue_motion.move(step_share);
  for (NeedleMotion& motion : motions) change = std::max(change, motion.move(step_share));
  return change;
}

// Whether the last correction was more than its linearisation is good for.
bool Simulation::World::went_too_far() const {
  return step_share < 1 ||
         std::any_of(motions.begin(), motions.end(), [](const NeedleMotion& m) { return m.turns_far(); });
}

// Forces by law and guide, remembered for the next tick and told to the report.
void Simulation::World::read_forces() {
  for (int i = 0; i < needles(); ++i) {
    report.needles[i].guide_force.setZero();
    insertions[i].read_forces(rows, report.needles[i]);
  }
  for (GuideHold& guide : guides) guide.read_forces(rows, report.needles[guide.needle()]);
}

bool Simulation::World::finite() const {
  return tissue_motion.finite() &&
         std::all_of(motions.begin(), motions.end(), [](const NeedleMotion& m) { return m.finite(); });
}

// The new positions become the state.
void Simulation::World::commit() {
  read_forces();
  balance_of_forces();
  for (int i = 0; i < needles(); ++i) {
    motions[i].commit(needle_states[i]);
    report.needles[i].base_force = -motions[i].base_reaction().head<3>();
    report.needles[i].base_torque = -motions[i].base_reaction().tail<3>();
  }
  tissue_motion.commit(tissue);
}

// Back to the state of the last good tick, without the work that spoilt this one.
void Simulation::World::hold() {
  for (int i = 0; i < needles(); ++i)
    motions[i].begin(needle_states[i], {needle_states[i].x.col(0), needle_states[i].q[0]});
  for (GuideHold& guide : guides) guide.hold();
  tissue_motion.restart();
  rows.clear();
  needle_balance.setZero();
  report.events.clear();
}

// The tissue's part of the balance needs the elements at the new positions, which the next tick evaluates: what is
// reported speaks of the tick before.
void Simulation::World::balance_of_forces() {
  const TissueMotion::Balance& b = tissue_motion.balance();
  report.imbalance = (needle_balance + b.support + b.weight - b.inertia).norm();
  report.largest_force =
      std::max({needle_largest_force, b.support.norm(), b.weight.norm(), b.inertia.norm()});
  needle_balance.setZero();
  needle_largest_force = 0;
  for (int i = 0; i < needles(); ++i) {
    const Vector3 base = motions[i].base_reaction().head<3>();
    needle_balance += base + report.needles[i].guide_force - motions[i].inertia_less_weight(needle_states[i]);
    needle_largest_force = std::max(needle_largest_force, base.norm());
  }
}

double Simulation::World::potential_energy() const {
  double energy = acus::potential_energy(tissue_model, tissue);
  for (int i = 0; i < needles(); ++i) energy += acus::potential_energy(needle_models[i], needle_states[i]);
  return energy;
}

Energy Simulation::World::energy() {
  Energy energy;
  energy.kinetic = kinetic_energy(tissue_model, tissue);
  energy.elastic = tissue_motion.elastic_energy(tissue.x) + rows.elastic_energy();
  energy.potential = potential_energy() - potential_at_start;
  for (int i = 0; i < needles(); ++i) {
    energy.kinetic += kinetic_energy(needle_models[i], needle_states[i]);
    energy.elastic += elastic_energy(needle_models[i], motions[i].shape());
  }
  return energy;
}

// 9. Contact, puncture, borders, growth of paths, exit, withdrawal.
std::uint32_t Simulation::World::transitions() {
  report.events.clear();
  std::uint32_t flags = 0;
  for (int i = 0; i < needles(); ++i) {
    flags |= insertions[i].transitions(needle_view(i), tissue_view(), tick, paths, report.events);
  }
  return flags;
}

// Compliance of the tetrahedra that the tips come to next, a node a tick, so that entering one costs no more than
// staying in it.
void Simulation::World::look_ahead() {
  for (int i = 0; i < needles(); ++i) {
    if (tick < next_look[i]) continue;
    const int here = insertions[i].tetrahedron_ahead(needle_view(i), tissue_view(), paths, 0);
    bool made = false;
    for (int step = 0; here >= 0 && step <= kStepsAhead && !made; ++step) {
      const double distance = step * kStepAhead * element_sizes[here];
      made = tissue_motion.prepare(insertions[i].tetrahedron_ahead(needle_view(i), tissue_view(), paths, distance));
    }
    if (!made) next_look[i] = tick + kLookEvery;
  }
}

// 10. What the outside is told.
void Simulation::World::write_report(std::uint32_t flags, const SolverResult& laws, int iterations) {
  report.tick = tick;
  report.time = static_cast<double>(tick) * h;
  report.flags = flags;
  report.rows = rows.count();
  report.solver = laws.method;
  report.sweeps = laws.sweeps;
  report.residual = laws.residual;
  report.newton_iterations = iterations;
  for (int i = 0; i < needles(); ++i) {
    NeedleReport& n = report.needles[i];
    n.command_seq = bases[i].command_seq();
    n.command_tick = bases[i].command_tick();
    n.phase = insertions[i].phase();
    n.inserted_depth = insertions[i].inserted_depth();
    n.base = {needle_states[i].x.col(0), needle_states[i].q[0]};
    n.spin = bases[i].spin();
    n.tip_position = needle_states[i].x.rightCols<1>();
  }
}

Simulation::Simulation(const Scene& scene, const Progress& progress)
    : world_(std::make_unique<World>(scene, progress)) {}
Simulation::~Simulation() = default;

void Simulation::step() {
  World& w = *world_;
  StageTimer timer(w.timing, w.report.stage_seconds);
  std::uint32_t flags = 0;
  SolverResult laws;

  w.take_commands(), timer.lap(1);
  const bool iterates = w.iterates();
  const int limit = w.max_iterations();
  int iteration = 0;
  bool again = true;
  for (; again && iteration < limit; ++iteration) {
    if (!w.needle_free_motion()) flags |= kTangentProjected;
    timer.lap(2);
    if (!w.tissue_free_motion()) flags |= kTangentProjected;
    timer.lap(3);
    if (iteration == 0) w.locate();
    timer.lap(4);
    if (!w.build_rows()) flags |= kRowsDropped;
    timer.lap(5);
    w.compute_compliance(), timer.lap(6);
    laws = w.solve_laws(), timer.lap(7);
    const double change = w.correct();
    timer.lap(8);
    again = iterates ? change > w.scene.newton.tolerance : w.went_too_far();
  }
  if (iterates && again) flags |= kNewtonNotConverged;
  if (w.went_too_far()) flags |= kStepLimited;
  if (w.tissue_motion.inverted()) flags |= kElementsInverted;
  if (!laws.converged) flags |= kLawsNotConverged;
  if (laws.fell_back) flags |= kSolverFellBack;
  if (again && limit < w.uncapped_iterations()) flags |= kIterationsCapped;
  if (laws.capped && w.max_sweeps() < w.scene.laws.max_sweeps) flags |= kSweepsCapped;

  if (w.finite()) {
    w.commit();
    flags |= w.transitions();
    w.look_ahead();
  } else {
    w.hold();
    flags |= kNotFinite;
  }
  timer.lap(9);
  w.write_report(flags, laws, iteration), timer.lap(10);
}

bool Simulation::command(int body, const Command& command) {
  World& w = *world_;
  return (body < w.needles() ? w.bases[body] : w.guides[body - w.needles()].motion()).command(command);
}
void Simulation::reset() { world_->reset(); }
void Simulation::economize(bool on) { world_->economizing = on; }
void Simulation::time_stages(bool on) { world_->timing = on; }

Energy Simulation::energy() const { return world_->energy(); }
const TickReport& Simulation::report() const { return world_->report; }
const Scene& Simulation::scene() const { return world_->scene; }
const TetrahedralMesh& Simulation::mesh() const { return world_->mesh; }
std::span<const int> Simulation::regions() const { return world_->regions; }
int Simulation::needle_node_count(int needle) const { return world_->needle_models[needle].nodes(); }
Costs Simulation::costs() const {
  const World& w = *world_;
  const TissueMotion& tissue = w.tissue_motion;
  const std::size_t entry = tissue.precision() == Precision::single_precision ? sizeof(float) : sizeof(double);
  return {static_cast<int>(w.tissue_model.free_nodes.size()),
          tissue.factor_entries(),
          tissue.factor_entries() * entry,
          tissue.corridor_nodes(),
          tissue.longest_column(),
          max_rows(w.scene)};
}
Eigen::Ref<const Matrix3X> Simulation::tissue_positions() const { return world_->tissue.x; }
Eigen::Ref<const Matrix3X> Simulation::needle_positions(int needle) const { return world_->needle_states[needle].x; }
std::span<const Quaternion> Simulation::needle_orientations(int needle) const {
  return world_->needle_states[needle].q;
}

int Simulation::max_paths() { return kMaxPaths; }

int Simulation::path_capacity() const { return vertices_per_path(world_->scene) + 1; }

int Simulation::path_positions(int path, Eigen::Ref<Matrix3X> points) const {
  const Path& p = world_->paths[path];
  for (int i = 0; i < p.points(); ++i)
    points.col(i) = material_position(world_->mesh, world_->tissue.x, p.point(i));
  return p.points();
}

}  // namespace acus
