// SPDX-License-Identifier: GPL-3.0-or-later
// What the simulation thread makes ready for the sockets, and what it leaves out.
#include "server/runtime/realtime_loop.h"

#include <doctest/doctest.h>

#include <memory>
#include <thread>

namespace acus {
namespace {

constexpr std::uint32_t kTicks = 21;  // few enough for all their records and shapes to fit in the queues

std::unique_ptr<LoadedScene> small_world() {
  Scene scene;
  scene.rate = 300;
  scene.tissue.box.cells = {3, 3, 3};
  scene.needles[0].base.position.z() = 0.5;  // far from the tissue
  scene.publish.needle_rate = scene.publish.tissue_rate = 100;
  return std::make_unique<LoadedScene>(scene);
}

// More than any machine can do in a tick: a thousand nodes, refactorised.
std::unique_ptr<LoadedScene> heavy_world() {
  Scene scene;
  scene.rate = 1000;
  scene.tissue.rung = TissueRung::exact;
  scene.tissue.box.cells = {9, 9, 9};
  scene.needles[0].base.position.z() = 0.5;
  scene.overrun.recovery = 1000;
  scene.publish.needle_rate = 1000;
  return std::make_unique<LoadedScene>(scene);
}

template <class What>
void ask(Link& link, What what) {
  Request* request = link.requests.writable();
  REQUIRE(request);
  *request = {0, std::move(what)};
  link.requests.commit();
  link.to_simulation.signal();
}

// How many of each there are; takes them out of the queues.
struct Ready {
  int forces = 0, ticks = 0, acknowledgements = 0, needle_shapes = 0, tissue_shapes = 0;

  bool operator==(const Ready&) const = default;
};

template <class T>
int count(SpscQueue<T>& queue) {
  int count = 0;
  for (; queue.readable(); queue.release()) ++count;
  return count;
}

Ready take(Link& link, LoadedScene& world) {
  Ready ready;
  for (; const Record* record = link.records.readable(); link.records.release()) {
    ready.forces += std::holds_alternative<ForceRecord>(*record);
    ready.ticks += std::holds_alternative<TickRecord>(*record);
    ready.acknowledgements += std::holds_alternative<Acknowledgement>(*record);
  }
  ready.needle_shapes = count(world.needle_frames);
  ready.tissue_shapes = count(world.tissue_frames);
  return ready;
}

// What is ready after kTicks ticks in lockstep with listeners to these topics.
Ready after_ticks(TopicSet wanted) {
  auto owned = small_world();
  LoadedScene& world = *owned;
  Link link;
  link.wanted = wanted;
  RealtimeLoop loop(std::move(owned), {.lockstep = true}, link);
  ask(link, request::Step{kTicks});
  ask(link, request::Shutdown{});
  loop.run();
  CHECK(loop.ticks() == kTicks);
  CHECK(link.dropped == 0);
  return take(link, world);
}

// A tick a second: a thread that slept through it would be deaf for that long.
std::unique_ptr<LoadedScene> slow_world() {
  Scene scene;
  scene.rate = 1;
  scene.tissue.rung = TissueRung::none;
  return std::make_unique<LoadedScene>(scene);
}

}  // namespace

// A loop that sleeps through its periods answers one request a tick. Waiting for these takes 20 of its ticks; a machine
// that stands still for seconds in between does no harm.
TEST_CASE("between ticks that are far apart requests are answered, and a signal to end is heard") {
  constexpr std::uint64_t kRequests = 20;
  Link link;
  RealtimeLoop loop(slow_world(), {}, link);
  {
    const std::jthread simulation([&] { loop.run(); });
    for (std::uint64_t epoch = 1; epoch <= kRequests; ++epoch) {
      ask(link, request::Reset{{epoch, nullptr}});
      while (link.epoch < epoch) std::this_thread::yield();
    }
    SUBCASE("the stop flag") { link.stop = true; }
    SUBCASE("a request") { ask(link, request::Shutdown{}); }
  }
  CHECK(loop.ticks() < kRequests / 2);
}

TEST_CASE("nothing is packed or recorded for topics that nobody listens to") {
  const int ticks = kTicks, shapes = kTicks / 3, answers = 2;
  CHECK(after_ticks(0) == Ready{0, 0, answers, 0, 0});
  CHECK(after_ticks(bit(Topic::event)) == Ready{0, 0, answers, 0, 0});
  CHECK(after_ticks(bit(Topic::force)) == Ready{ticks, 0, answers, 0, 0});
  CHECK(after_ticks(bit(Topic::stats)) == Ready{0, ticks, answers, 0, 0});
  CHECK(after_ticks(bit(Topic::needle)) == Ready{0, 0, answers, shapes, 0});
  CHECK(after_ticks(bit(Topic::tissue)) == Ready{0, 0, answers, 0, shapes});
  CHECK(after_ticks(bit(Topic::force) | bit(Topic::tissue)) == Ready{ticks, 0, answers, 0, shapes});
}

TEST_CASE("after a tick that took too long shapes are left out, flags say so, and forces go out as before" *
          doctest::test_suite("gate")) {
  constexpr std::uint64_t kManyTicks = 20;
  auto owned = heavy_world();
  LoadedScene& world = *owned;
  const double time_step = world.hello.time_step;
  const auto every = static_cast<std::uint64_t>(world.simulation.scene().overrun.publish_every);
  Link link;
  link.wanted = bit(Topic::force) | bit(Topic::needle) | bit(Topic::stats);
  RealtimeLoop loop(std::move(owned), {.max_ticks = kManyTicks}, link);
  loop.run();

  std::uint64_t tick = 0, left = 0;  // left: shapes that are yet to be left out
  std::vector<std::uint64_t> packed;
  for (; const Record* record = link.records.readable(); link.records.release()) {
    if (const auto* force = std::get_if<ForceRecord>(record)) {
      CHECK(force->tick == ++tick);
      CHECK(((force->flags & kPublishingReduced) != 0) == (left > 0));
    } else {
      const TickTiming& timing = std::get<TickRecord>(*record).timing;
      if (left > 0) {
        --left;
        continue;
      }
      packed.push_back(tick);
      if (timing.overran(time_step)) left = every - 1;
    }
  }
  CHECK(tick == kManyTicks);
  CHECK(packed.size() < kManyTicks);
  CHECK(link.overruns > 0);
  CHECK(loop.punctuality().late > 0);
  CHECK(loop.punctuality().economized >= kManyTicks - packed.size());
  CHECK(loop.punctuality().ended.count() == kManyTicks);
  std::vector<std::uint64_t> shapes;
  for (; const NeedleFrame* frame = world.needle_frames.readable(); world.needle_frames.release())
    shapes.push_back(frame->shape.tick);
  CHECK(shapes == packed);
}

TEST_CASE("a reset begins with everything that the scene asks for" * doctest::test_suite("gate")) {
  Link link;
  link.wanted = bit(Topic::force) | bit(Topic::needle);
  RealtimeLoop loop(heavy_world(), {.max_ticks = 40}, link);
  {
    const std::jthread simulation([&] { loop.run(); });
    while (link.tick < 5) std::this_thread::yield();
    ask(link, request::Reset{{1, nullptr}});
  }

  std::uint32_t before = 0;  // the flags of all ticks before the reset
  int first_ticks = 0;
  for (; const Record* record = link.records.readable(); link.records.release()) {
    const auto* force = std::get_if<ForceRecord>(record);
    if (!force) continue;
    if (force->epoch == 0) before |= force->flags;
    if (force->epoch == 0 || force->tick > 1) continue;
    CHECK((force->flags & kPublishingReduced) == 0);
    ++first_ticks;
  }
  CHECK((before & kPublishingReduced) != 0);
  CHECK(first_ticks == 1);
}

}  // namespace acus
