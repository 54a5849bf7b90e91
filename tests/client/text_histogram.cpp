// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/replay/text_histogram.h"

#include <doctest/doctest.h>

#include <sstream>

using acus::client::round_up;
using acus::client::text_histogram;

namespace {

struct Row {
  double begin = 0;  // ms
  std::size_t count = 0;
  std::string bar;
};

std::vector<Row> rows_of(const std::string& text) {
  std::vector<Row> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line.substr(0, 8) + line.substr(13));
    Row& row = rows.emplace_back();
    cells >> row.begin >> row.count >> row.bar;
  }
  return rows;
}

}  // namespace

TEST_CASE("widths are round") {
  CHECK(round_up(0.001) == doctest::Approx(0.001));
  CHECK(round_up(0.0011) == doctest::Approx(0.002));
  CHECK(round_up(3) == doctest::Approx(5));
  CHECK(round_up(70) == doctest::Approx(100));
}

TEST_CASE("every time is in one row, the far ones in the last, and whatever is there shows") {
  std::vector<double> times;
  for (int i = 0; i < 1000; ++i) times.push_back(1e-3 + 1e-7 * i);
  times.push_back(5);
  const auto rows = rows_of(text_histogram(times));
  REQUIRE(rows.size() == acus::client::kHistogramRows + 2);
  std::size_t sum = 0, longest = 0;
  for (const Row& row : rows) {
    sum += row.count;
    longest = std::max(longest, row.bar.size());
    CHECK((row.count > 0) == !row.bar.empty());
  }
  CHECK(sum == times.size());
  CHECK(longest == acus::client::kHistogramColumns);
  CHECK(rows.front().begin == doctest::Approx(1));
  CHECK(rows.back().count == 1);
}

TEST_CASE("no times make no histogram, equal ones a single bar") {
  CHECK(text_histogram({}).empty());
  const auto rows = rows_of(text_histogram({2e-3, 2e-3, 2e-3}));
  std::size_t bars = 0;
  for (const Row& row : rows) bars += row.bar.empty() ? 0 : 1;
  CHECK(bars == 1);
}
