// SPDX-License-Identifier: GPL-3.0-or-later
// A steel needle whose handle is moved and turned while its tip is loaded, to 115 mm of deflection on a length of
// 262 mm, or while springs hold its front part, against a commercial multibody code.
//
// Source: five runs of MSC ADAMS, beams of a chain of rigid bodies (github.com/amartsop/AdamsAnalysis), read from
// ../shared/data/adams_needle where somebody has put them. The tip's place relative to the base, and the base's force
// where the handle does not turn: the reaction at the handle less the force on its own 90 g.
//
// Not compared: the first 0.2 s, since the handle sets out with a jump of its speed, and 2.5 to 3 s, since the load
// ends with a jump, and the tip goes back by millimetres in a tick of 1 ms.
#include <algorithm>
#include <array>
#include <fstream>
#include <numbers>
#include <sstream>
#include <vector>

#include "server/engine/math/rotation.h"
#include "tests/models/bench_needle.h"
#include "tests/references/figure.h"
#include "tests/support/shared_data.h"

namespace acus {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kGravity = 9.80665;                           // m/s²
constexpr double kStep = 1e-3;                                 // s
constexpr double kHandleMass = 0.09;                           // kg
constexpr double kLoad = 0.6;                                  // N
constexpr double kSetOut = 0.2, kLoadEnds = 2.5, kAtRest = 3;  // s
constexpr double kSpring = 0.2, kDamper = 2e-3;                // N/m and N s/m, at a node, along z
constexpr int kBeams = 51, kFirstHeld = 22;                    // the code's points are the nodes here
const Vector3 kNeedleInHandle(76.5e-3, 0, -7.67e-3);           // m, from the point about which the handle turns

struct Sample {
  double t;
  Vector3 force, tip;  // N, m
};

std::vector<Sample> read_run(const std::string& path) {
  std::vector<Sample> samples;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    std::array<double, 16> n{};  // time, handle's pose, force, moment, tip, and more that is not needed
    for (double& number : n) numbers >> number;
    samples.push_back({n[0], {n[7], n[8], n[9]}, {n[13], n[14], n[15]}});
  }
  return samples;
}

NeedleModel needle() {
  NeedleBody body;
  body.length = 0.2623;
  body.beams = kBeams;
  body.outer_diameter = 1.27e-3;
  body.material = {200e9, 200 / (2 * 79.3) - 1, 7850, 0, 0.01};
  return make_needle_model(body, {0, 0, -kGravity});
}

enum class Turn { none, about_y, about_all };

struct Run {
  int number;
  double amplitude;  // m, and rad where it turns
  Turn turn = Turn::none;
  Vector3 along = Vector3::UnitZ();  // of the motion and of the load
  bool springs = false;
};

Pose base_at(const Run& run, double t) {
  const double a = run.amplitude * std::sin(kPi * t);
  const auto about = [&](const Vector3& axis) { return rotation_exp(a * axis); };
  Quaternion turn = Quaternion::Identity();
  if (run.turn == Turn::about_y) turn = about(Vector3::UnitY());
  if (run.turn == Turn::about_all) turn = about(Vector3::UnitX()) * about(Vector3::UnitY()) * about(Vector3::UnitZ());
  return {a * run.along + turn * kNeedleInHandle, turn};
}

// The loads of a tick on the shape that is iterated, as rows with the force 1.
void add_loads(const Run& run, double t, const NeedleState& state, const NeedleModel& model, NeedleMotion& motion,
               std::vector<double>& lambda) {
  motion.clear_rows();
  lambda.clear();
  const auto add = [&](const NeedleLoad& load) {
    motion.add_row(load.beam, load.force);
    lambda.push_back(1);
  };
  if (!run.springs) {
    const double force = t < kLoadEnds ? kLoad * std::tanh(t) : 0;
    add(tip_load(model, force * run.along, Vector3::Zero()));
    return;
  }
  for (int node = kFirstHeld; node <= kBeams; ++node) {
    const double z = motion.shape().x(2, node), speed = (z - state.x(2, node)) / kStep;
    NeedleLoad load{node - 1, Vector12::Zero()};
    load.force[8] = -kSpring * (z - kNeedleInHandle.z()) - kDamper * speed;
    add(load);
  }
}

struct Differences {
  double tip = 0, deflection = 0;  // m: largest difference; largest deflection of the source
  double force = 0, largest = 0;   // N, likewise
};

Differences compare(const Run& run, const std::vector<Sample>& samples) {
  const NeedleModel model = needle();
  NeedleState state = make_needle_state(model, base_at(run, 0));
  NeedleMotion motion(model, kStep, kBeams);
  std::vector<double> lambda;
  Differences result;
  auto next = samples.begin() + 1;
  for (int i = 1; next != samples.end(); ++i) {
    const double t = i * kStep;
    const Pose base = base_at(run, t);
    motion.begin(state, base);
    double moved = 1;
    for (int iteration = 0; iteration < 30 && moved > 1e-10; ++iteration) {
      motion.linearize(state);
      add_loads(run, t, state, model, motion, lambda);
      moved = motion.correct(lambda);
    }
    motion.commit(state);
    if (t < next->t - kStep / 2) continue;
    const Sample& sample = *next++;
    if (t < kSetOut || (!run.springs && t >= kLoadEnds && t < kAtRest)) continue;
    const Vector3 straight = base * Vector3(model.length, 0, 0);
    result.tip = std::max(result.tip, (state.x.col(kBeams) - sample.tip).norm());
    result.deflection = std::max(result.deflection, (sample.tip - straight).norm());
    if (run.turn != Turn::none) continue;
    const double handle = kHandleMass * (kGravity - run.amplitude * kPi * kPi * std::sin(kPi * t));
    const Vector3 force = sample.force - handle * Vector3::UnitZ();
    result.force = std::max(result.force, (motion.base_reaction().head<3>() - force).norm());
    result.largest = std::max(result.largest, force.norm());
  }
  return result;
}

TEST_CASE("a needle on a moving handle bends as in a commercial multibody code") {
  const std::vector<Run> runs{
      {1, 0.2},
      {2, 0.2},
      {3, 0.2, Turn::about_y},
      {4, 0.2, Turn::about_all, Vector3::Ones()},
      {.number = 5, .amplitude = 0.1, .springs = true},
  };
  for (const Run& run : runs) {
    const std::string number = std::to_string(run.number);
    const std::string path = shared_data("adams_needle/adams" + number + ".csv");
    if (path.empty()) return;
    const std::vector<Sample> samples = read_run(path);
    REQUIRE(samples.size() > 400);
    const Differences d = compare(run, samples);
    CHECK(agrees("multibody, run " + number + ", tip: difference / largest deflection", 0, d.tip / d.deflection, 1e-3));
    if (d.largest > 0)
      CHECK(agrees("multibody, run " + number + ", force: difference / largest", 0, d.force / d.largest, 1e-3));
    CHECK(d.deflection > 0.05);
  }
}

}  // namespace
}  // namespace acus
