// SPDX-License-Identifier: GPL-3.0-or-later
// What leaves for a viewer that is slower than the server.
#include "client/view/outbox.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace acus::view {
namespace {

Frame frame(const std::string& topic, const std::string& needle, const std::string& bytes, double force = 0) {
  return {topic, needle, force, std::make_shared<const std::string>(bytes)};
}

std::vector<std::string> taken(Outbox& outbox) {
  std::vector<std::string> texts;
  for (const auto& bytes : outbox.take()) texts.push_back(*bytes);
  return texts;
}

using Texts = std::vector<std::string>;

TEST_CASE("of many forces the smallest, the largest and the last leave, in their order") {
  Outbox outbox;
  for (int tick = 0; tick < 100; ++tick)
    outbox.put(frame("force", "needle", std::to_string(tick), tick == 40 ? 9 : tick == 60 ? 0.5 : 1));
  CHECK(taken(outbox) == Texts{"40", "60", "99"});
  CHECK(taken(outbox).empty());
}

TEST_CASE("a state leaves once, whatever it is") {
  Outbox outbox;
  outbox.put(frame("force", "needle", "only", 1));
  CHECK(taken(outbox) == Texts{"only"});
  outbox.put(frame("force", "needle", "first", 1));
  outbox.put(frame("force", "needle", "second", 2));
  CHECK(taken(outbox) == Texts{"first", "second"});
}

TEST_CASE("of tips of other worlds the newest leave") {
  Outbox outbox;
  for (const char* bytes : {"first", "second"}) outbox.put(frame("cloud", "", bytes));
  CHECK(taken(outbox) == Texts{"second"});
}

TEST_CASE("no peak is lost, wherever departures fall") {
  for (int departure = 1; departure < 40; ++departure) {
    Outbox outbox;
    double largest = 0, largest_sent = 0;
    const auto leave = [&] {
      for (const std::string& text : taken(outbox)) largest_sent = std::max(largest_sent, std::stod(text));
    };
    for (int tick = 0; tick < 200; ++tick) {
      const double force = std::abs(std::sin(0.37 * tick) * std::sin(0.05 * tick + departure));
      largest = std::max(largest, force);
      outbox.put(frame("force", "needle", std::to_string(force), force));
      if (tick % departure == 0) leave();
    }
    leave();
    CHECK(largest_sent == doctest::Approx(largest).epsilon(1e-5));
  }
}

TEST_CASE("a late departure has a force for each 20 ms, and of a long delay a bounded number, evenly") {
  for (const int ticks : {100, 1'000, 100'000}) {
    Outbox outbox;
    for (int tick = 0; tick < ticks; ++tick) {
      Frame state = frame("force", "needle", std::to_string(tick), 1);
      state.time = 1e-3 * tick;
      outbox.put(state);
    }
    const Texts texts = taken(outbox);
    double gap = 0;
    for (std::size_t i = 1; i < texts.size(); ++i)
      gap = std::max(gap, 1e-3 * (std::stoi(texts[i]) - std::stoi(texts[i - 1])));
    CHECK(gap <= std::max(Outbox::kStep, 1e-3 * ticks / (Outbox::kMostSteps / 2 - 1)) + 1e-3);
    CHECK(texts.size() <= Outbox::kMostSteps + 3);
    CHECK(texts.back() == std::to_string(ticks - 1));
  }
}

TEST_CASE("after a reset time goes on from its start") {
  Outbox outbox;
  for (const double time : {5.0, 0.0, 0.01, 0.03}) {
    Frame state = frame("force", "needle", std::to_string(time), 1);
    state.time = time;
    outbox.put(state);
  }
  CHECK(taken(outbox) == Texts{std::to_string(5.0), std::to_string(0.03)});
}

TEST_CASE("needles do not stand in each other's way") {
  Outbox outbox;
  outbox.put(frame("force", "left", "l", 1));
  outbox.put(frame("force", "right", "r", 5));
  outbox.put(frame("needle", "left", "old"));
  outbox.put(frame("needle", "right", "shape of right"));
  outbox.put(frame("needle", "left", "shape of left"));
  CHECK(taken(outbox) == Texts{"l", "r", "shape of left", "shape of right"});
}

TEST_CASE("of shapes and stats the newest leaves") {
  Outbox outbox;
  for (int i = 0; i < 10; ++i) {
    outbox.put(frame("tissue", "", "t" + std::to_string(i)));
    outbox.put(frame("stats", "", "s" + std::to_string(i)));
  }
  CHECK(taken(outbox) == Texts{"s9", "t9"});
}

TEST_CASE("events all leave, before the states that follow them; beyond a bound the oldest are counted") {
  Outbox outbox;
  for (const char* text : {"a", "b", "c"}) outbox.put(frame("event", "needle", text));
  outbox.put(frame("force", "needle", "f", 1));
  CHECK(taken(outbox) == Texts{"a", "b", "c", "f"});
  CHECK(outbox.lost() == 0);
  for (std::size_t i = 0; i < Outbox::kMostEvents + 7; ++i) outbox.put(frame("event", "needle", std::to_string(i)));
  CHECK(outbox.lost() == 7);
  const Texts texts = taken(outbox);
  CHECK(texts.size() == Outbox::kMostEvents);
  CHECK(texts.front() == "7");
}

TEST_CASE("a server that makes up needles, or sends much that cannot be read, fills no memory") {
  Outbox outbox;
  for (int i = 0; i < 10'000; ++i) outbox.put(frame("force", std::to_string(i), "f", 1));
  CHECK(taken(outbox).size() <= Outbox::kMostNeedles + 1);
  const auto large = std::make_shared<const std::string>(std::string(1 << 20, 'x'));
  for (int i = 0; i < 200; ++i) outbox.put({"", "", 0, large});
  CHECK(outbox.take().size() == Outbox::kMostBytes >> 20);
}

TEST_CASE("answers, and what cannot be read, leave as they come") {
  Outbox outbox;
  outbox.put(frame("", "", "answer"));
  outbox.put(frame("", "", "garbage"));
  CHECK(taken(outbox) == Texts{"answer", "garbage"});
}

}  // namespace
}  // namespace acus::view
