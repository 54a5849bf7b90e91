// SPDX-License-Identifier: GPL-3.0-or-later
// The map of stable and unstable haptic loops: tissue, device rate, network, grip and mass, pressed, inserted and
// turned, with the kit and without it.
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
  double tissue = 0;  // N/m, or N m/rad

  bool stable() const { return outcome.swing < kCycle && outcome.twist < kTwistCycle; }
  Cell of_puncture(double value) const { return outcome.punctured && !setting.turns ? value : NAN; }
};

constexpr Column<Row> kColumns[] = {
    {"task", [](const Row& row) -> Cell { return row.setting.turns ? "turn" : "insert"; }},
    {"stiffness_Pa", [](const Row& row) -> Cell { return row.setting.young_modulus; }},
    {"rate_Hz", [](const Row& row) -> Cell { return row.setting.rate; }},
    {"delay_ms", [](const Row& row) -> Cell { return 1e3 * row.setting.network.delay; }},
    {"jitter_ms", [](const Row& row) -> Cell { return 1e3 * row.setting.network.jitter; }},
    {"loss", [](const Row& row) -> Cell { return row.setting.network.loss; }},
    {"grip", [](const Row& row) -> Cell { return row.setting.grip.name; }},
    {"mass_kg", [](const Row& row) -> Cell { return row.setting.mass; }},
    {"kit", [](const Row& row) -> Cell { return row.setting.kit; }},
    {"stable", [](const Row& row) -> Cell { return row.stable(); }},
    {"felt_over_bound",
     [](const Row& row) -> Cell {
       return row.stable() ? row.outcome.felt / felt_bound(row.setting, row.tissue) : NAN;
     }},
    {"energy_J", [](const Row& row) -> Cell { return row.outcome.made; }},
    {"swing_N", [](const Row& row) -> Cell { return row.outcome.swing; }},
    {"twist_Nm", [](const Row& row) -> Cell { return row.outcome.twist; }},
    {"felt", [](const Row& row) -> Cell { return row.stable() ? row.outcome.felt : NAN; }},
    {"tissue", [](const Row& row) -> Cell { return row.tissue; }},
    {"held", [](const Row& row) -> Cell { return row.outcome.held; }},
    {"wanted", [](const Row& row) -> Cell { return row.outcome.wanted; }},
    {"at_server", [](const Row& row) -> Cell { return row.outcome.at_server; }},
    {"withheld_J", [](const Row& row) -> Cell { return row.outcome.withheld; }},
    {"largest_force_N", [](const Row& row) -> Cell { return row.outcome.largest_force; }},
    {"punctured", [](const Row& row) -> Cell { return row.outcome.punctured; }},
    {"puncture_force_N",
     [](const Row& row) -> Cell { return row.of_puncture(puncture_force(row.setting.young_modulus)); }},
    {"puncture_felt_N", [](const Row& row) -> Cell { return row.of_puncture(row.outcome.puncture_felt); }},
    {"puncture_rise_N", [](const Row& row) -> Cell { return row.of_puncture(row.outcome.puncture_rise); }},
    {"puncture_drop_N", [](const Row& row) -> Cell { return row.of_puncture(row.outcome.puncture_drop); }},
    {"server_drop_N", [](const Row& row) -> Cell { return row.of_puncture(row.outcome.server_drop); }},
    {"chatter_N", [](const Row& row) -> Cell { return row.outcome.chatter; }},
};

// A block of the map: all combinations of these.
struct Block {
  std::vector<double> stiffnesses;  // Pa
  std::vector<double> rates;        // Hz
  std::vector<haptics::LinkDelay> networks;
  std::vector<haptics::Grip> grips;
  std::vector<double> masses{0.1};  // kg
  bool turns = false, kit = true;
};

haptics::LinkDelay network(double delay, double jitter = 0, double loss = 0) {
  return {.delay = delay, .jitter = jitter, .loss = loss};
}

std::vector<Block> blocks_of(bool quick) {
  const auto& [fingertips, relaxed, firm] = haptics::kGrips;
  const std::vector<double> few{1e3, 1e5, 1e9}, stiffnesses{1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
  const std::vector<double> rates{100, 400, 1000, 4000}, three{100, 1000, 4000};
  const haptics::LinkDelay none = network(0), bad = network(20e-3, 10e-3, 0.05);
  if (quick)
    return {{few, three, {bad}, {fingertips}},
            {few, {1000}, {none}, {fingertips}},
            {{1e5}, {1000}, {bad}, {fingertips}, {0.1}, true},
            {{1e5}, {1000}, {bad}, {fingertips}, {0.1}, false, false}};
  const std::vector<haptics::LinkDelay> delays{none, network(5e-3), network(10e-3), network(20e-3)};
  const std::vector<haptics::LinkDelay> lossy{network(10e-3, 5e-3, 0.01), bad};
  return {{stiffnesses, rates, delays, {fingertips, relaxed, firm}},
          {stiffnesses, rates, lossy, {fingertips, relaxed}},
          {stiffnesses, rates, {none, bad}, {fingertips}, {0.05, 0.3}},
          {stiffnesses, rates, {none, bad}, {fingertips, firm}, {0.1}, true},
          {few, rates, {none, bad}, {fingertips, firm}, {0.1}, false, false}};
}

std::vector<HapticSetting> settings_of(const std::vector<Block>& blocks) {
  std::vector<HapticSetting> settings;
  for (const Block& block : blocks)
    for (const double stiffness : block.stiffnesses)
      for (const double rate : block.rates)
        for (const haptics::LinkDelay& network : block.networks)
          for (const haptics::Grip& grip : block.grips)
            for (const double mass : block.masses)
              settings.push_back({stiffness, rate, network, grip, mass, block.turns, block.kit});
  return settings;
}

}  // namespace

void study_haptics(const StudyPlan& plan) {
  CsvFile file(plan.out + "/" + plan.haptics_table, names_of(kColumns));
  const std::vector<HapticSetting> settings = settings_of(blocks_of(plan.quick));
  std::map<double, double> tissue;  // N/m by Pa
  const int count = static_cast<int>(settings.size());
  for (int i = plan.part; i < count; i += plan.parts) {
    const HapticSetting& setting = settings[static_cast<std::size_t>(i)];
    plan.progress(i, count, std::to_string(setting.young_modulus) + " Pa");
    if (!tissue.contains(setting.young_modulus))
      tissue[setting.young_modulus] = pressed_stiffness(setting.young_modulus);
    const HapticOutcome outcome = run_haptic(setting);
    file.row(cells_of(kColumns, {setting, outcome, setting.turns ? outcome.tissue : tissue[setting.young_modulus]}));
  }
}

}  // namespace acus
