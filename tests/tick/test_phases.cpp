// SPDX-License-Identifier: GPL-3.0-or-later
// The phases of a needle: the documents show the arrows that the code knows, and no tick goes another way.
#include <doctest/doctest.h>

#include <set>
#include <string>

#include "server/engine/math/random.h"
#include "server/engine/state/needle/phase.h"
#include "tests/support/file_content.h"
#include "tests/support/places.h"
#include "tests/tick/bench.h"

namespace acus::test {

namespace {

std::string name(Phase phase) { return protocol::kPhaseNames[static_cast<std::size_t>(phase)]; }
std::string name(EventKind kind) { return protocol::kEventKindNames[static_cast<std::size_t>(kind)]; }

std::string table() {
  std::string rows = "| from | to | event | when |\n|---|---|---|---|\n";
  for (const PhaseChange& change : kPhaseChanges)
    rows += "| `" + name(change.from) + "` | `" + name(change.to) + "` | `" + name(change.event) + "` | " +
            change.when + " |\n";
  return rows;
}

// The diagram at the head of state/needle/phase.h, without the comment's slashes.
std::string diagram() {
  const std::string header = content_of(source_path("server/engine/state/needle/phase.h"));
  const std::size_t first = header.find("\n//  "), last = header.find("\n// kPhaseChanges");
  REQUIRE(first != std::string::npos);
  REQUIRE(last != std::string::npos);
  std::string drawn;
  for (std::size_t begin = first + 1; begin < last;) {
    const std::size_t end = header.find('\n', begin);
    const std::string line = header.substr(begin, end - begin);
    drawn += line.size() > 2 ? "   " + line.substr(2) + '\n' : "\n";
    begin = end + 1;
  }
  return drawn.substr(0, drawn.find_last_not_of('\n') + 1) + '\n';
}

}  // namespace

TEST_CASE("MODEL.md and the contract have the table of phases, and MODEL.md the diagram") {
  for (const char* page : {"server/MODEL.md", "protocol/README.md"}) {
    CAPTURE(page);
    const std::string text = content_of(source_path(page));
    CHECK_MESSAGE(text.find(table()) != std::string::npos, "expected this table:\n" << table());
  }
  const std::string model = content_of(source_path("server/MODEL.md"));
  CHECK_MESSAGE(model.find(diagram()) != std::string::npos, "expected this diagram:\n" << diagram());
}

// Bench holds after every tick that the events explain the phase.
TEST_CASE("whatever a hand does, a phase changes along an arrow whose event is told" * doctest::test_suite("gate")) {
  Random random(7);
  const Scene scene = read_scene(source_path("scenes/through.yaml"));
  for (int i = 0; i < 4; ++i) {
    CAPTURE(i);
    Bench bench(scene);
    std::set<Phase> seen;
    bench.each_tick = [&] { seen.insert(bench.needle().phase); };
    double depth = 0;
    for (int move = 0; move < 8; ++move) {
      const double to = random.uniform(-0.01, 0.07);
      bench.push(0, to - depth, random.uniform(0.05, 0.4));
      depth = to;
    }
    CHECK(seen.size() == 4);
  }
}

}  // namespace acus::test
