// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/error_settings.h"

#include <cmath>
#include <map>

#include "server/engine/scene/text/field.h"

namespace acus {

namespace {

const std::vector<double> kSteps{0.25e-3, 0.5e-3, 1e-3, 2e-3, 5e-3, 10e-3, 20e-3, 1.0 / 30};  // s
constexpr double kCoarseSteps[] = {2e-3, 5e-3, 10e-3, 20e-3, 1.0 / 30};                       // s, of meshes
constexpr double kExactStep = 1.0 / 30;                                                         // s, of rung exact

void keep(Scene&) {}

void solve_laws_exactly(Scene& scene) {
  scene.laws = {.solver = LawMethod::direct, .max_steps = 100000, .tolerance = 1e-10};
}

void converge(Scene& scene) {
  scene.tissue.rung = TissueRung::refined;
  scene.newton = {.max_iterations = 100, .tolerance = 1e-12};
  solve_laws_exactly(scene);
}

void converge_exactly(Scene& scene) {
  converge(scene);
  scene.tissue.rung = TissueRung::exact;
}

auto on_rung(TissueRung rung) {
  return [rung](Scene& s) { s.tissue.rung = rung; };
}

auto refined(int iterations) {
  return [iterations](Scene& s) {
    s.tissue.rung = TissueRung::refined;
    s.newton.max_iterations = iterations;
  };
}

auto swept(double tolerance, int most) {
  return [=](Scene& s) { s.laws = {.solver = LawMethod::gauss_seidel, .max_steps = most, .tolerance = tolerance}; };
}

auto with_cells(const std::array<int, 3>& cells) {
  return [cells](Scene& s) { s.tissue.box.cells = cells; };
}

std::string milliseconds(double h) { return format_number(std::round(h * 1e5) / 100) + " ms"; }
std::string millimetres(double length) { return format_number(1e3 * length) + " mm"; }

class Settings {
 public:
  explicit Settings(const StudiedScene& studied) : studied_(studied) {}

  std::vector<Setting> make() {
    for (const double h : studied_.steps) add_converged(h);
    for (const double h : studied_.steps) add_rungs(h);
    if (converged_.contains(kExactStep)) add_rung("exact", kExactStep, converge_exactly);
    add_laws();
    add_beams();
    add_spacings();
    if (!studied_.cells.empty()) add_meshes();
    return std::move(all_);
  }

 private:
  std::size_t next() const { return all_.size(); }

  void add_converged(double h) {
    converged_[h] = next();
    all_.push_back({"time step", milliseconds(h), h, converge, {{"total", 0}}});
  }

  void add_rung(const char* name, double h, std::function<void(Scene&)> change) {
    all_.push_back({"rung", name, h, std::move(change), {{"solver", converged_.at(h)}, {"total", 0}}});
  }

  void add_rungs(double h) {
    add_rung("linear", h, on_rung(TissueRung::linear));
    add_rung("warped", h, keep);
    add_rung("refined 2", h, refined(2));
    if (h >= kStandardStep) add_rung("refined 3", h, refined(3));
  }

  void add_laws() {
    const std::size_t direct = next();
    const auto add = [&](const char* knob, const std::string& value, std::function<void(Scene&)> change) {
      all_.push_back({knob, value, kStandardStep, std::move(change), {{"laws", direct}, {"total", 0}}});
    };
    add("laws", "direct", solve_laws_exactly);
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-6, 1e-9})
      add("gauss_seidel tolerance", format_number(tolerance) + " N", swept(tolerance, 100000));
    for (const int most : {1, 4, 16, 64}) add("gauss_seidel steps", std::to_string(most), swept(1e-9, most));
  }

  void add_beams() {
    const std::size_t finest = next();
    for (const int beams : studied_.beams)
      all_.push_back({"beams",
                      std::to_string(beams),
                      kStandardStep,
                      [beams](Scene& s) { s.needles[0].beams = beams; },
                      {{"discretisation", finest}}});
  }

  void add_spacings() {
    const std::size_t finest = next();
    for (const double spacing : studied_.spacings)
      all_.push_back({"spacing",
                      millimetres(spacing),
                      kStandardStep,
                      [spacing](Scene& s) { s.needles[0].constraint_spacing = spacing; },
                      {{"discretisation", finest}}});
  }

  void add_meshes() {
    const std::size_t finest = next();
    for (const auto& cells : studied_.cells)
      all_.push_back({"cells",
                      std::to_string(cells[0]),
                      kStandardStep,
                      with_cells(cells),
                      {{"discretisation", finest}, {"overall", finest}}});
    for (const auto& cells : studied_.cells)
      for (const double h : kCoarseSteps)
        if (converged_.contains(h))
          all_.push_back({"cells", std::to_string(cells[0]), h, with_cells(cells), {{"overall", finest}}});
  }

  const StudiedScene& studied_;
  std::map<double, std::size_t> converged_;  // per time step
  std::vector<Setting> all_;
};

}  // namespace

std::vector<StudiedScene> studied_scenes(bool quick) {
  const std::vector<double> spacings{1e-3, 2e-3, 4e-3, 8e-3, 16e-3};
  if (quick)
    return {{"insertion_pullback",
             8,
             {1e-3, 2e-3, 5e-3, 10e-3, 20e-3},
             {{9, 9, 9}, {5, 5, 5}, {3, 3, 3}},
             {100, 50, 10},
             {2e-3, 4e-3, 8e-3}}};
  return {
      {"insertion_pullback",
       2,
       kSteps,
       {{14, 14, 14}, {9, 9, 9}, {5, 5, 5}, {3, 3, 3}},
       {200, 100, 50, 20, 10, 5},
       spacings},
      {"steering",
       1,
       kSteps,
       {{16, 16, 24}, {12, 12, 18}, {8, 8, 12}, {4, 4, 6}},
       {200, 100, 60, 20, 10, 5},
       spacings},
      {"inclusion_supported", 1, kSteps, {}, {200, 100, 40, 20, 10, 5}, spacings},
  };
}

std::vector<Setting> settings_of(const StudiedScene& studied) { return Settings(studied).make(); }

}  // namespace acus
