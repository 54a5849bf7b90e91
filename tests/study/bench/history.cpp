// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/bench/history.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace acus {

namespace {

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  if (line.empty() || line.back() == ',') cells.emplace_back();
  return cells;
}

double ratio_of(const std::string& cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !(value > 0))
    throw std::runtime_error("expected a ratio above zero, found '" + cell + "'");
  return value;
}

HistoryRow row_of(const std::string& line) {
  const std::vector<std::string> cells = cells_of(line);
  const auto columns =
      std::count(kHistoryColumns, kHistoryColumns + std::char_traits<char>::length(kHistoryColumns), ',') + 1;
  if (static_cast<std::ptrdiff_t>(cells.size()) != columns)
    throw std::runtime_error("expected " + std::to_string(columns) + " cells, found " + std::to_string(cells.size()));
  return {cells[0], cells[1], cells[2], cells[3], cells[4], ratio_of(cells[5]), ratio_of(cells[6]), cells[7], cells[8]};
}

}  // namespace

std::string processor_name() {
  std::map<std::string, std::string> first;
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(':');
    if (colon == std::string::npos) continue;
    const auto key = line.substr(0, line.find_last_not_of(" \t", colon - 1) + 1);
    first.try_emplace(key, line.substr(std::min(line.size(), colon + 2)));
  }
  std::string name = first["model name"] + " family " + first["cpu family"] + " model " + first["model"];
  std::replace(name.begin(), name.end(), ',', ' ');
  return name;
}

std::vector<HistoryRow> read_history(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line) || line != kHistoryColumns)
    throw std::runtime_error(path + ": expected a file that begins with the line " + kHistoryColumns);
  std::vector<HistoryRow> rows;
  for (int number = 2; std::getline(file, line); ++number) {
    try {
      rows.push_back(row_of(line));
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(path + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  return rows;
}

std::optional<HistoryRow> last_comparable(const std::vector<HistoryRow>& history, const HistoryRow& now) {
  const auto row = std::find_if(history.rbegin(), history.rend(), [&](const HistoryRow& other) {
    return other.processor == now.processor && other.kernels == now.kernels && other.scene == now.scene;
  });
  if (row == history.rend()) return std::nullopt;
  return *row;
}

std::vector<RatioComparison> compare(const HistoryRow& before, const HistoryRow& now) {
  return {{"tick p50 / calibration", before.to_calibration, now.to_calibration},
          {"tick p99 / p50", before.p99_to_p50, now.p99_to_p50}};
}

}  // namespace acus
