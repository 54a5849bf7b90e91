// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings of the simulation thread: whenever they begin and whatever happens to the world meanwhile, they come out the
// same when they are run again.
#include "server/runtime/recorder.h"

#include <doctest/doctest.h>

#include <thread>

#include "server/engine/recording/rerun.h"
#include "server/runtime/realtime_loop.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

std::unique_ptr<LoadedScene> world_of(const std::string& scene) {
  return std::make_unique<LoadedScene>(read_scene(test::scene_file(scene)));
}

// A loop in lockstep, and this thread in the place of the one that serves sockets.
class Session {
 public:
  explicit Session(std::unique_ptr<LoadedScene> world)
      : newest_(world.get()),
        loop_(std::move(world), {.lockstep = true}, link_),
        thread_([this] { loop_.run(); }) {}
  ~Session() {
    link_.stop = true;
    link_.to_simulation.signal();
  }

  // Moves the first needle's base along its axis, and turns it, in so many ticks.
  void push(int ticks, double distance) {
    const Needle& needle = newest_->simulation.scene().needles[0];
    for (int i = 0; i < ticks; ++i) {
      reach_ += distance / ticks;
      Pose pose = needle.base;
      pose.position += needle.base.orientation * Vector3::UnitX() * reach_;
      link_.commands[0].put({epoch_, {.seq = ++seq_, .pose = pose, .spin = 10 * reach_}, {}});
      carry_out(request::Step{1});
    }
  }

  void record(Recorder* recorder) {
    carry_out(request::Record{recorder, recorder ? box() : nullptr});
    recording_ = recorder != nullptr;
  }

  void reset() {
    carry_out(request::Reset{begin_epoch()});
    reach_ = 0;
  }

  void restore(const State& state, double reach) {
    carry_out(request::Restore{begin_epoch(), std::make_unique<State>(state)});
    reach_ = reach;
  }

  void replace(std::unique_ptr<LoadedScene> world) {
    newest_ = world.get();
    carry_out(request::ReplaceWorld{begin_epoch(), std::move(world)});
    reach_ = 0;
  }

  // Nothing happens between requests, so that it may be looked at from here.
  const Simulation& simulation() const { return newest_->simulation; }
  double reach() const { return reach_; }

 private:
  std::unique_ptr<StateBox> box() const {
    auto box = std::make_unique<StateBox>();
    box->state = make_state(newest_->simulation.model());
    return box;
  }

  NewEpoch begin_epoch() { return {++epoch_, recording_ ? box() : nullptr}; }

  template <class What>
  void carry_out(What what) {
    Request* request = link_.requests.writable();
    REQUIRE(request);
    *request = {0, std::move(what)};
    link_.requests.commit();
    link_.to_simulation.signal();
    for (bool done = false; !done;) {
      const Record* record = link_.records.readable();
      if (!record) {
        std::this_thread::yield();
        continue;
      }
      done = std::holds_alternative<Acknowledgement>(*record);
      link_.records.release();
    }
  }

  LoadedScene* newest_;
  Link link_;
  RealtimeLoop loop_;
  std::uint64_t epoch_ = 0, seq_ = 0;
  double reach_ = 0;  // m, of the first needle's base
  bool recording_ = false;
  std::jthread thread_;
};

struct RunAgain {
  std::uint64_t ticks = 0;
  int worlds = 0;
  bool same = false;
  std::string problem;

  bool operator==(const RunAgain&) const = default;
};

RunAgain run_again(const std::string& path) {
  Rerun rerun(path);
  while (rerun.step()) {
  }
  return {rerun.ticks(), rerun.worlds(), !rerun.difference(), rerun.problem()};
}

}  // namespace

TEST_CASE("a recording that begins and ends in the middle of a run is made again to the last bit" *
          doctest::test_suite("gate")) {
  const TemporaryFolder folder;
  for (const char* scene : {"insertion_pullback", "brachytherapy", "inclusion_supported", "steering", "through"}) {
    CAPTURE(scene);
    Session session(world_of(scene));
    session.push(150, 0.03);
    {
      Recorder recorder(folder / scene, "test");
      session.record(&recorder);
      session.push(150, 0.03);
      session.push(50, -0.02);
      session.record(nullptr);
      CHECK(recorder.recording());
    }
    session.push(10, 0.01);
    CHECK(run_again(folder / scene) == RunAgain{200, 1, true, ""});
  }
}

TEST_CASE("a recording goes on through a reset, a restored state and another scene" * doctest::test_suite("gate")) {
  const TemporaryFolder folder;
  {
    Session session(world_of("layers"));
    Recorder recorder(folder / "run", "test");
    session.record(&recorder);
    session.push(100, 0.04);
    const State state = session.simulation().state();
    const double reach = session.reach();
    session.push(50, 0.01);
    session.reset();
    session.push(20, 0.01);
    session.restore(state, reach);
    session.push(50, 0.01);
    session.replace(world_of("inclusion_supported"));
    session.push(60, 0.03);
    session.record(nullptr);
  }
  CHECK(run_again(folder / "run") == RunAgain{280, 2, true, ""});
}

TEST_CASE("what a recorder is asked for when it may not write any more is left out, and nobody waits" *
          doctest::test_suite("gate")) {
  const TemporaryFolder folder;
  Session session(world_of("inclusion_supported"));
  Recorder recorder(folder / "run", "test");
  session.record(&recorder);
  session.push(10, 0.01);
  recorder.give_up();  // as the loop does in real time when the queue is full
  while (recorder.recording()) std::this_thread::yield();
  session.push(10, 0.01);
  session.reset();
  session.push(static_cast<int>(session.simulation().scene().rate) + 10, 0.02);  // the state of a second is due in it
  session.record(nullptr);
  CHECK(run_again(folder / "run") == RunAgain{10, 1, true, "the disk did not keep up with the simulation"});
}

}  // namespace acus
