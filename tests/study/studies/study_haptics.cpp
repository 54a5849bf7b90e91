// SPDX-License-Identifier: GPL-3.0-or-later
// The map of stable and unstable haptic loops: tissue, device rate, delay and grip, with the kit and without it.
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/study/studies/csv.h"
#include "tests/study/studies/haptic_run.h"
#include "tests/study/studies/study.h"

namespace acus {

namespace {

struct Row {
  HapticSetting setting;
  HapticOutcome outcome;
  double tissue = 0;  // N/m

  bool stable() const { return outcome.swing < kCycle; }
};

constexpr Column<Row> kColumns[] = {
    {"stiffness_Pa", [](const Row& row) -> Cell { return row.setting.young_modulus; }},
    {"rate_Hz", [](const Row& row) -> Cell { return row.setting.rate; }},
    {"delay_ms", [](const Row& row) -> Cell { return 1e3 * row.setting.delay; }},
    {"grip", [](const Row& row) -> Cell { return row.setting.grip.name; }},
    {"kit", [](const Row& row) -> Cell { return row.setting.kit; }},
    {"stable", [](const Row& row) -> Cell { return row.stable(); }},
    {"felt_over_bound",
     [](const Row& row) -> Cell {
       return row.stable() ? row.outcome.felt / felt_bound(row.setting, row.tissue) : NAN;
     }},
    {"energy_J", [](const Row& row) -> Cell { return row.outcome.made; }},
    {"swing_N", [](const Row& row) -> Cell { return row.outcome.swing; }},
    {"felt_N_per_m", [](const Row& row) -> Cell { return row.stable() ? row.outcome.felt : NAN; }},
    {"tissue_N_per_m", [](const Row& row) -> Cell { return row.tissue; }},
    {"withheld_J", [](const Row& row) -> Cell { return row.outcome.withheld; }},
    {"largest_force_N", [](const Row& row) -> Cell { return row.outcome.largest_force; }},
    {"punctured", [](const Row& row) -> Cell { return row.outcome.punctured; }},
    {"puncture_drop_N", [](const Row& row) -> Cell { return row.outcome.punctured ? row.outcome.puncture_drop : NAN; }},
    {"server_drop_N", [](const Row& row) -> Cell { return row.outcome.punctured ? row.outcome.server_drop : NAN; }},
    {"chatter_N", [](const Row& row) -> Cell { return row.outcome.chatter; }},
};

struct Map {
  std::vector<double> stiffnesses;  // Pa
  std::vector<double> rates;        // Hz
  std::vector<double> delays;       // s
  std::vector<haptics::Grip> grips;
};

Map map_of(bool quick) {
  const auto& grips = haptics::kGrips;
  if (quick) return {{1e3, 1e5, 1e9}, {100, 1000, 4000}, {0, 20e-3}, {grips[0], grips[2]}};
  return {{1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9},
          {100, 400, 1000, 4000},
          {0, 5e-3, 10e-3, 20e-3},
          {grips[0], grips[1], grips[2]}};
}

std::vector<HapticSetting> settings_of(const Map& map) {
  std::vector<HapticSetting> settings;
  for (const double stiffness : map.stiffnesses)
    for (const double rate : map.rates)
      for (const double delay : map.delays)
        for (const haptics::Grip& grip : map.grips)
          for (const bool kit : {true, false}) settings.push_back({stiffness, rate, delay, grip, kit});
  return settings;
}

}  // namespace

void study_haptics(const StudyPlan& plan) {
  CsvFile file(plan.out + "/" + plan.haptics_table, names_of(kColumns));
  const std::vector<HapticSetting> settings = settings_of(map_of(plan.quick));
  std::map<double, double> tissue;  // N/m by Pa
  const int count = static_cast<int>(settings.size());
  for (int i = plan.part; i < count; i += plan.parts) {
    const HapticSetting& setting = settings[static_cast<std::size_t>(i)];
    plan.progress(i, count, std::to_string(setting.young_modulus) + " Pa");
    if (!tissue.contains(setting.young_modulus))
      tissue[setting.young_modulus] = pressed_stiffness(setting.young_modulus);
    file.row(cells_of(kColumns, {setting, run_haptic(setting), tissue[setting.young_modulus]}));
  }
}

}  // namespace acus
