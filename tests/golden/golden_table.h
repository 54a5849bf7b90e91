// SPDX-License-Identifier: GPL-3.0-or-later
// The table of hashes: a CSV file with one row per scene, rung and solver.
#pragma once

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace acus::test {

struct GoldenRow {
  std::string scene, rung, solver;
  std::uint64_t ticks = 0;
  std::uint64_t hash = 0;

  bool same_run(const GoldenRow& other) const {
    return scene == other.scene && rung == other.rung && solver == other.solver;
  }
  std::string text() const {
    char hex[17];
    std::snprintf(hex, sizeof hex, "%016" PRIx64, hash);
    return scene + "," + rung + "," + solver + "," + std::to_string(ticks) + "," + hex;
  }
};

class GoldenTable {
 public:
  // A file that is not there is an empty table.
  static GoldenTable read(const std::string& file) {
    GoldenTable table;
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);  // the header
    while (std::getline(in, line)) {
      std::istringstream cells(line);
      GoldenRow row;
      std::string ticks, hash;
      std::getline(cells, row.scene, ',');
      std::getline(cells, row.rung, ',');
      std::getline(cells, row.solver, ',');
      std::getline(cells, ticks, ',');
      std::getline(cells, hash, ',');
      row.ticks = std::stoull(ticks);
      row.hash = std::stoull(hash, nullptr, 16);
      table.rows_.push_back(row);
    }
    return table;
  }

  void write(const std::string& file) const {
    std::ofstream out(file);
    out << "scene,rung,solver,ticks,xxh3_64\n";
    for (const GoldenRow& row : rows_) out << row.text() << '\n';
    if (!out.flush()) throw std::runtime_error(file + ": cannot be written");
  }

  const GoldenRow* find(const GoldenRow& run) const {
    for (const GoldenRow& row : rows_)
      if (row.same_run(run)) return &row;
    return nullptr;
  }

  void put(const GoldenRow& run) {
    for (GoldenRow& row : rows_)
      if (row.same_run(run)) {
        row = run;
        return;
      }
    rows_.push_back(run);
  }

 private:
  std::vector<GoldenRow> rows_;
};

}  // namespace acus::test
