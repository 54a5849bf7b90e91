// SPDX-License-Identifier: GPL-3.0-or-later
// Servers that start with a recording: the state of any moment of it, and what is refused.
#include "server/runtime/recorded_start.h"

#include <doctest/doctest.h>
#include <zstd.h>

#include <fstream>

#include "tests/support/recorded_run.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

using test::RecordedRun;

constexpr double kTick = 0.002;  // s, of the scene

const auto kNever = [] { return false; };

std::unique_ptr<LoadedScene> start(RecordedRun& run, std::optional<double> at = {}) {
  run.writer().flush();
  return load_recorded({run.writer().path(), at}, kNever);
}

std::uint64_t hash_of(const Simulation& simulation) {
  State copy = simulation.state();
  return comparable_hash(copy);
}

std::string error_of(const std::string& path, std::optional<double> at = {}) {
  try {
    load_recorded({path, at}, kNever);
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

void cut_off(const std::string& path, std::uintmax_t bytes) {
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - bytes);
}

}  // namespace

TEST_CASE("the state of a moment is that of the recording after the nearest tick, bit by bit") {
  const TemporaryFolder folder;
  RecordedRun run(folder / "run");
  std::vector<std::uint64_t> hashes{hash_of(run.simulation())};
  for (int i = 0; i < 120; ++i) {
    run.tick(i % 50 > 40);
    hashes.push_back(hash_of(run.simulation()));
  }
  CHECK(run.simulation().report().needles[0].phase == Phase::inside);
  for (const int tick : {0, 1, 45, 119, 120}) {
    CAPTURE(tick);
    for (const double off : {0.0, -0.4 * kTick, 0.4 * kTick}) {
      const auto world = start(run, std::max(0.0, tick * kTick + off));
      CHECK(world->simulation.report().tick == static_cast<std::uint64_t>(tick));
      CHECK(hash_of(world->simulation) == hashes[static_cast<std::size_t>(tick)]);
      CHECK(!world->simulation.state().economizing);
    }
  }
  CHECK(hash_of(start(run)->simulation) == hashes.back());
}

TEST_CASE("what starts with a recording goes on as its simulation does from a snapshot") {
  const TemporaryFolder folder;
  RecordedRun run(folder / "run");
  for (int i = 0; i < 100; ++i) run.tick();
  const auto world = start(run);
  Simulation& original = run.simulation();
  original.restore(read_snapshot(original.model(), make_snapshot(original.model().fingerprint, original.state())));
  for (int i = 0; i < 20; ++i) {
    const Command command = run.next_command();
    for (Simulation* simulation : {&original, &world->simulation}) {
      if (i >= 5) CHECK(simulation->command(0, command));  // before, bases go where they were going
      simulation->step();
    }
  }
  CHECK(world->simulation.report().tick == 120);
  CHECK(hash_of(world->simulation) == hash_of(original));
}

TEST_CASE("seconds are those of all ticks, also where ticks count anew, and a recording may change its scene") {
  const TemporaryFolder folder;
  RecordedRun run(folder / "run");
  for (int i = 0; i < 10; ++i) run.tick();
  run.simulation().reset();
  run.begin(1);
  for (int i = 0; i < 10; ++i) run.tick();
  const std::uint64_t before = hash_of(run.simulation());
  Scene other = test::small_block();
  other.rate = 250;
  run.load(other);
  run.begin(2);
  for (int i = 0; i < 10; ++i) run.tick();
  const auto earlier = start(run, 20 * kTick);
  CHECK(earlier->simulation.report().tick == 10);
  CHECK(hash_of(earlier->simulation) == before);
  const auto later = start(run, 20 * kTick + 10 * 0.004);
  CHECK(later->simulation.scene().rate == 250);
  CHECK(later->simulation.report().tick == 10);
  CHECK(hash_of(later->simulation) == hash_of(run.simulation()));
}

TEST_CASE("a recording that comes out otherwise is gone on from, as it came out") {
  const TemporaryFolder folder;
  RecordedRun run(folder / "run");
  run.go_wrong();
  for (int i = 0; i < 10; ++i) run.tick();
  CHECK(hash_of(start(run)->simulation) == hash_of(run.simulation()));
}

TEST_CASE("a rerun that is interrupted gives nothing") {
  const TemporaryFolder folder;
  RecordedRun run(folder / "run");
  for (int i = 0; i < 10; ++i) run.tick();
  run.writer().flush();
  int asked = 0;
  CHECK(!load_recorded({run.writer().path(), {}}, [&] { return ++asked == 4; }));
  CHECK(asked == 4);
}

TEST_CASE("what no server can go on from is refused, with what to do instead") {
  const TemporaryFolder folder;
  const std::string path = folder / "run";
  RecordedRun run(path);
  for (int i = 0; i < 10; ++i) run.tick();
  SUBCASE("a moment behind the end") {
    run.writer().add(recorded::Ending{""});
    run.writer().flush();
    CHECK(error_of(path, 0.0211) == path + ": --at 0.0211: the recording ends after 0.02 s; give no more than that");
    CHECK(error_of(path, 0.0209) == "");
  }
  SUBCASE("an end that is damaged, but not what stands before it") {
    run.writer().flush();
    for (int i = 0; i < 10; ++i) run.tick();
    run.writer().flush();
    cut_off(path, 1);
    CHECK(error_of(path).ends_with("is damaged or not whole; --at 0.02 goes on from the last tick before that"));
    CHECK(error_of(path, 0.03).find("the recording ends after 0.02 s, as what stands from byte") != std::string::npos);
    CHECK(error_of(path, 0.02) == "");
  }
  SUBCASE("a state of another version") {
    run.writer().add(recorded::Beginning{1, std::vector<std::byte>(100)});
    run.tick();
    run.writer().flush();
    CHECK(error_of(path).starts_with(path + ": a state of the recording cannot be used: "));
  }
}

TEST_CASE("a recording without a whole state to begin with is refused at any moment") {
  const TemporaryFolder folder;
  RecordingWriter writer(folder / "run");
  writer.add(recorded::Opening{1, "0.1", ""});
  writer.flush();
  writer.add(recorded::Beginning{0, std::vector<std::byte>(100)});
  writer.flush();
  cut_off(writer.path(), 1);
  for (const std::optional<double> at : {std::optional<double>(), std::optional(0.0)})
    CHECK(error_of(writer.path(), at).starts_with(writer.path() + ": there is nothing to go on from: what stands from "));
}

TEST_CASE("a recording of another version is refused, and says which one") {
  const TemporaryFolder folder;
  RecordingWriter writer(folder / "run");
  writer.add(recorded::Opening{1, "0.0.7", ""});
  writer.add(recorded::World{"small.yaml", test::small_block().text, 500, 1, {}});
  writer.add(recorded::Beginning{0, std::vector<std::byte>(100)});
  writer.flush();
  const std::string error = error_of(writer.path());
  CHECK(error.find("the scene in the recording means something else") != std::string::npos);
  CHECK(error.find("start the version that recorded it, acus-server 0.0.7 (this is ") != std::string::npos);
}

TEST_CASE("a recording is known by what it begins with, not by its name") {
  const TemporaryFolder folder;
  RecordedRun run(folder / "run.yaml");
  run.writer().flush();
  CHECK(is_recording(folder / "run.yaml"));
  CHECK(!is_recording(folder.write("scene.acus", "acus_scene: 1\n")));
  CHECK(!is_recording(folder.write("short", "\x28\xb5")));
  CHECK(!is_recording(folder / "none"));
  CHECK(!is_recording("."));
  std::string packed(100, '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), "hello", 5, 3));
  const std::string foreign = folder.write("foreign", packed);
  CHECK(is_recording(foreign));
  CHECK(error_of(foreign).starts_with(foreign + ": "));
}

}  // namespace acus
