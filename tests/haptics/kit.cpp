// SPDX-License-Identifier: GPL-3.0-or-later
// The whole loop: a simulated handle and hand, the kit, a delay, and a tissue with a closed form.
#include "client/haptics/kit.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <limits>
#include <new>

#include "client/haptics/analytic_tissue.h"
#include "client/haptics/simulated_device.h"
#include "client/haptics/simulated_handle.h"

using namespace acus::haptics;

namespace {

thread_local bool counting = false;
thread_local int allocations = 0;

}  // namespace

// Counts what is allocated while a test asks for it.
void* operator new(std::size_t size) {
  if (counting) ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

struct Command {
  double place = 0;
  std::uint64_t seq = 0;
};

// Device, network and tissue, with time that a test moves on.
struct Loop {
  Loop(double rate, double delay, const AnalyticTissue::Properties& properties, const Grip& grip = kGrips[0],
       const KitOptions& options = {})
      : device(with_rate(rate)),
        tissue(properties),
        handle({device.translation, {0, 0, 1}, grip.hand}),
        kit(device, options),
        up({delay / 2, 0, 1}),
        down({delay / 2, 0, 1}) {
    kit.begin({}, {});
  }

  static DeviceProperties with_rate(double rate) {
    DeviceProperties device;
    device.rate = rate;
    return device;
  }

  // One sample, and as many ticks of 1 ms of the tissue as fall into it.
  void step(double place, double speed) {
    const double h = periods / device.rate;
    for (; next_tick <= now + 1e-9; next_tick += 1e-3) {
      while (const auto command = up.receive(next_tick)) in_use = *command;
      tissue.step(in_use.place);
      LocalModel model = tissue.model();
      model.seq = in_use.seq;
      down.send(next_tick, model);
    }
    while (const auto model = down.receive(now)) {
      kit.take(*model);
      newest = *model;
    }
    answer = kit.step({{handle.measured(), {}}, clutch, told ? elapsed : 0});
    elapsed = h;
    handle.write(answer.on_hand.force);
    up.send(now, {answer.base.position[0], answer.seq});
    handle.mean({{place, 0, 0}}, {{speed, 0, 0}});
    handle.advance(h);
    now += h;
  }
  // The hand goes to a place at a speed, then rests there for a time.
  void go(double to, double speed, double rest) {
    const double step_way = speed / device.rate;
    while (std::abs(to - meant) > step_way) {
      meant += to > meant ? step_way : -step_way;
      step(meant, to > meant ? speed : -speed);
    }
    meant = to;
    for (const double end = now + rest; now < end;) {
      step(meant, 0);
      if (now < end - rest / 3) continue;
      least = std::min(least, answer.on_hand.force[0]);
      most = std::max(most, answer.on_hand.force[0]);
    }
  }
  // N, peak to peak of the force in the last third of the rest; begins anew.
  double swing() {
    const double swung = most - least;
    least = std::numeric_limits<double>::infinity(), most = -least;
    return swung;
  }

  DeviceProperties device;
  AnalyticTissue tissue;
  SimulatedHandle handle;
  Kit kit;
  DelayLine<Command> up;
  DelayLine<LocalModel> down;
  Command in_use;
  LocalModel newest;
  Kit::Answer answer;
  bool clutch = false;
  int periods = 1;        // sample times until the next sample,
  bool told = true;       // and whether the kit is told of them
  double elapsed = 1e-3;  // s, since the last sample
  double now = 0, next_tick = 0, meant = 0;
  double least = std::numeric_limits<double>::infinity(), most = -least;
};

}  // namespace

TEST_CASE("tissue of steel's stiffness, 20 ms of delay, 100 Hz: passive, and as stiff as the rule says") {
  for (const Grip& grip : kGrips) {
    Loop loop(100, 20e-3, {1e6, 1e9, 0.5, 0.3, 0.01}, grip);
    loop.go(0.03, 0.05, 2);
    CHECK(loop.swing() < 0.05);
    const double force = loop.answer.on_hand.force[0], place = loop.handle.position()[0];
    loop.go(0.04, 0.05, 2);
    CHECK(loop.swing() < 0.05);
    const double stiffness = -(loop.answer.on_hand.force[0] - force) / (loop.handle.position()[0] - place);
    CHECK(stiffness == doctest::Approx(loop.kit.coupling().translation).epsilon(0.05));
    loop.go(0, 0.05, 1);
    CHECK(loop.handle.most_made() < 1e-9);
  }
}

TEST_CASE("a puncture is felt as a drop within one sample of the device") {
  for (const double delay : {0.0, 20e-3}) {
    Loop loop(1000, delay, {300, 1, 0.5, 0.1, 0.01}, kGrips[2]);
    double before = 0;
    while (loop.newest.backward_limit != Limit::slip && loop.now < 5) {  // until a model knows of it
      before = loop.answer.on_hand.force[0];
      loop.meant += 0.02 / 1000;
      loop.step(loop.meant, 0.02);
    }
    CHECK(before < -0.9);
    // Cutting and friction bear 0.6 N.
    CHECK(loop.answer.on_hand.force[0] > -0.65);
  }
}

TEST_CASE("a puncture may have a transient: a period of a sine on top, paid for, and nothing is left of it") {
  constexpr double kHeight = 0.3, kLength = 0.02;
  KitOptions options;
  options.transient = {kHeight, kLength};
  for (const double rate : {400.0, 1000.0, 4000.0}) {
    CAPTURE(rate);
    Loop plain(rate, 0, {300, 1, 0.5, 0.1, 0.01}, kGrips[2]),
        sharp(rate, 0, {300, 1, 0.5, 0.1, 0.01}, kGrips[2], options);
    double most = 0, least = 0, sum = 0, left = 0, since = -1;
    while (since < 0.1) {
      if (since < 0 && plain.newest.backward_limit == Limit::slip) {
        sharp.kit.begin_transient();
        since = 0;
      }
      for (Loop* loop : {&plain, &sharp}) {
        loop->meant += 0.02 / rate;
        loop->step(loop->meant, 0.02);
      }
      const double more = sharp.answer.on_hand.force[0] - plain.answer.on_hand.force[0];
      if (since < 0) {
        CHECK(more == 0);  // until an event comes nothing is different
      } else {
        most = std::max(most, more), least = std::min(least, more), sum += more / rate;
        if ((since += 1 / rate) > 0.08) left = std::max(left, std::abs(more));
      }
    }
    CHECK(most == doctest::Approx(kHeight).epsilon(0.15));  // ahead, with the needle
    CHECK(least == doctest::Approx(-kHeight).epsilon(0.15));
    CHECK(std::abs(sum) < 0.05 * kHeight * kLength);
    CHECK(left < 0.01);
    CHECK(sharp.handle.most_made() < 1e-9);
  }
}

TEST_CASE("a hand that runs into bone feels no more than fast_force until it is slower than fast") {
  for (const double rate : {400.0, 1000.0, 4000.0}) {
    CAPTURE(rate);
    Loop loop(rate, 5e-3, {1e6, 1e9, 0.5, 0.3, 0.05}, kGrips[2]);
    double most = 0, slow = 0;
    for (int i = 0; i < 0.4 * rate; ++i) {
      const bool stops = loop.meant > 0.08;
      if (!stops) loop.meant += 1.5 / rate;
      loop.step(loop.meant, stops ? 0 : 1.5);
      const double speed = norm(loop.handle.velocity());
      double& felt = speed > 0.6 ? most : slow;
      felt = std::max(felt, norm(loop.answer.on_hand.force));
    }
    CHECK(most <= 3 + 1e-12);
    CHECK(most > 1);
    CHECK(slow > 5);  // then it is bone
    CHECK(loop.handle.most_made() < 1e-9);
  }
}

TEST_CASE("samples that come late are no source of energy once the kit is told of them") {
  const auto made = [](bool told) {
    Loop loop(1000, 0, {1e6, 1e9, 0.5, 0.3, 0.002}, kGrips[0]);
    loop.told = told;
    std::uint64_t random = 5;
    for (int i = 0; i < 4000; ++i) {
      loop.periods = next_random(random) < 0.3 ? 1 + static_cast<int>(19 * next_random(random)) : 1;
      loop.step(0.01 * (1 - std::cos(6 * loop.now)), 0.06 * std::sin(6 * loop.now));
    }
    return loop.handle.most_made();
  };
  CHECK(made(false) > 1e-3);
  CHECK(made(true) < 1e-4);
}

TEST_CASE("a transient never gives what the hand has not paid") {
  KitOptions options;
  options.transient = {5, 0.02};
  Loop loop(1000, 0, {300, 1, 0.5, 0.1, 1}, kGrips[0], options);  // in air
  for (int i = 0; i < 50; ++i) {
    loop.kit.begin_transient();
    loop.go(loop.meant + (i % 2 == 0 ? 1e-3 : -1e-3), 0.05, 0.02);
    CHECK(loop.kit.passivity().account() >= 0);
  }
  CHECK(loop.handle.most_made() < 1e-9);
}

TEST_CASE("a needle stuck in friction does not swing, with or without delay") {
  for (const double delay : {0.0, 20e-3})
    for (const double stiffness : {100.0, 300.0, 2000.0, 1e5}) {
      Loop loop(1000, delay, {stiffness, 0.8, 0.4, 0.3, 0.01});
      loop.go(0.06, 0.05, 1.2);
      CHECK(loop.swing() < 0.05);
      loop.go(0.03, 0.05, 1.2);
      CHECK(loop.swing() < 0.05);
      CHECK(loop.handle.most_made() < 1e-9);
    }
}

// What a tick of h (s) tells of a base at x (m) that a force (N) resists; stiffness and limits are not known yet.
LocalModel model_of_tick(std::uint64_t tick, double h, std::uint64_t seq, double x, double force) {
  LocalModel model;
  model.tick = tick;
  model.time = h * static_cast<double>(tick);
  model.seq = seq;
  model.base.position[0] = x;
  model.felt.force[0] = -force;
  return model;
}

// A needle in a tissue so stiff that it sticks within a micrometre and slides beyond: a tick at the border tells no
// stiffness but the needle's inertia.
struct StiffFriction {
  static constexpr double h = 1e-3, stiffness = 3e5, inertia = 1000;  // s, N/m, N/m
  static constexpr double ahead = 0.7, back = 0.2;                    // N, that it bears

  LocalModel step(double x, std::uint64_t seq) {
    const bool inside = x > 0;
    const double before = anchor;
    if (inside) anchor = std::clamp(anchor, x - ahead / stiffness, x + back / stiffness);
    const double force = inside ? stiffness * (x - anchor) : 0;
    const bool at_limit = anchor != before || force > ahead - 1e-6 || force < -back + 1e-6;
    LocalModel model = model_of_tick(++tick, h, seq, x, force);
    model.stiffness(0, 0) = -inertia - (inside && !at_limit ? stiffness : 0);
    model.put_limits(inside ? ahead : 0, inside ? back : 0, true);
    return model;
  }

  double anchor = 0;  // m
  std::uint64_t tick = 0;
};

TEST_CASE("in a tissue too stiff to be seen between two messages, a needle under a still device comes to rest") {
  for (const double rate : {100.0, 400.0, 1000.0}) {
    CAPTURE(rate);
    Kit kit(Loop::with_rate(rate));
    kit.begin({}, {{{-1e-3, 0, 0}}, {}});
    StiffFriction tissue;
    Kit::Answer answer;
    answer.base.position[0] = -1e-3;
    double least = 1, most = -1, next_tick = 0;
    for (double now = 0; now < 2; now += 1 / rate) {
      for (; next_tick <= now + 1e-9; next_tick += StiffFriction::h)
        kit.take(tissue.step(answer.base.position[0], answer.seq));
      answer = kit.step({{{{std::min(0.05 * now, 5e-3), 0, 0}}, {}}, false});
      if (now < 1.5) continue;
      least = std::min(least, answer.base.position[0]);
      most = std::max(most, answer.base.position[0]);
    }
    CHECK(most > 2e-3);
    CHECK(most - least < 5e-6);
  }
}

TEST_CASE("a needle that slides has no stiffness along it, also where its ways and turns are coupled") {
  Kit kit(Loop::with_rate(1000));
  kit.begin({}, {});
  LocalModel model;  // in air
  model.tick = 1;
  model.stiffness(0, 0) = -900;
  kit.take(model);
  model.tick = 2;  // sliding back
  model.felt.force[0] = 0.2;
  model.stiffness(0, 4) = model.stiffness(4, 0) = -200;
  model.stiffness(4, 4) = -1;
  model.put_limits(0.2, 0.2, false);
  kit.take(model);
  double wanted = 0;
  for (int i = 1; i <= 100; ++i) wanted = kit.step({{{{i * 1e-6, 0, 0}}, {}}, false}).wanted.force[0];
  CHECK(wanted == doctest::Approx(-0.2));  // it has stuck, and slides ahead
}

// A viscous surface under a needle of mass m, whose base goes where it is told at every tick, and what a tick tells:
// the tissue's force, and the stiffness of a motion within the tick, inertia and viscosity included.
struct ViscousSurface {
  static constexpr double h = 1e-3, stiffness = 3000, viscosity = 30, mass = 1e-3;  // s, N/m, N s/m, kg

  LocalModel step(double x, std::uint64_t seq) {
    const double moved = viscosity / h;
    const double left = moved * depth / (stiffness + moved);  // m, where the surface comes to by itself
    const double force = std::max((stiffness + moved) * (x - left), 0.0);
    depth = force > 0 ? x : left;
    LocalModel model = model_of_tick(++tick, h, seq, x, force);
    model.stiffness(0, 0) = -mass / (h * h) - (force > 0 ? stiffness + moved : 0);
    model.put_limits(force > 0 ? 1e6 : 0, 0, false);
    return model;
  }

  double depth = 0;  // m, of the surface under the tip
  std::uint64_t tick = 0;
};

TEST_CASE("a needle that a still device holds against a viscous surface comes to rest where the springs have it") {
  for (const int delay : {0, 5, 20})  // ms
    for (const double rate : {1000.0, 4000.0}) {
      CAPTURE(delay);
      CAPTURE(rate);
      Kit kit(Loop::with_rate(rate));
      kit.begin({}, {});
      ViscousSurface surface;
      DelayLine<LocalModel> link({1e-3 * delay, 0, 1});
      constexpr double kAt = 0.5e-3, kSeconds = 2;  // m beyond the surface
      const double spring = kit.coupling().translation_spring;
      const double rest = kAt * spring / (spring + ViscousSurface::stiffness);
      Kit::Answer answer;
      double least = 1, most = -1, next_tick = 0;
      for (double now = 0; now < kSeconds; now += 1 / rate) {
        if (now >= next_tick - 1e-9) {
          link.send(now, surface.step(answer.base.position[0], answer.seq));
          next_tick += ViscousSurface::h;
        }
        while (const auto model = link.receive(now)) kit.take(*model);
        answer = kit.step({{{{std::min(now / 0.1, 1.0) * kAt, 0, 0}}, {}}, false});
        if (now < kSeconds / 2) continue;
        least = std::min(least, answer.base.position[0]);
        most = std::max(most, answer.base.position[0]);
      }
      CHECK(most - least < 1e-6);
      CHECK(most == doctest::Approx(rest).epsilon(0.01));
    }
}

TEST_CASE("a needle that a surface throws off for a tick still feels it ahead, until it is seen beyond it") {
  DeviceProperties device;
  Kit kit(device);
  kit.begin({}, {});
  LocalModel model;  // pressed by 1 N at x = 1 mm
  model.tick = 1;
  model.base.position[0] = 1e-3;
  model.felt.force[0] = -1;
  model.stiffness(0, 0) = -1e4;
  model.backward = 1e-4;
  model.forward_limit = Limit::puncture;
  model.backward_limit = Limit::contact;
  kit.take(model);
  const auto wanted = [&kit](double place) {
    Kit::Answer answer;
    for (int i = 0; i < 100; ++i) answer = kit.step({{{{place, 0, 0}}, {}}, false});
    return answer.wanted.force[0];
  };
  const double pressed = wanted(2e-3);
  CHECK(pressed < -1);
  const auto in_air = [&](double place, double aside) {
    LocalModel air;
    air.tick = ++model.tick;
    air.base.position = {{place, aside, 0}};
    kit.take(air);
    return wanted(2e-3);
  };
  CHECK(in_air(0.8e-3, 0) == doctest::Approx(pressed));  // thrown off
  CHECK(in_air(0.5e-3, 0) == doctest::Approx(pressed));
  CHECK(in_air(0.8e-3, 2e-3) == 0);  // elsewhere: nothing is known of it
  model.tick += 1;
  kit.take(model);
  CHECK(wanted(2e-3) < -1);
  CHECK(in_air(0.95e-3, 0) == 0);  // beyond it: the surface has gone
}

TEST_CASE("what is stale ends in a ramp, and nothing jumps when it comes back") {
  DeviceProperties device;
  Kit kit(device);
  kit.begin({}, {});
  LocalModel model;
  model.felt.force[0] = -0.5;
  model.stiffness(0, 0) = -500;
  model.backward_limit = Limit::contact;
  Pose place;
  double before = 0, largest_step = 0;
  const auto run = [&](int samples, bool fresh) {
    for (int i = 0; i < samples; ++i) {
      if (fresh) ++model.tick, kit.take(model);
      const double force = kit.step({place, false}).on_hand.force[0];
      largest_step = std::max(largest_step, std::abs(force - before));
      before = force;
    }
  };
  for (int i = 0; i < 100; ++i) {  // work that pays for the force
    place.position[0] += 1e-5;
    run(1, true);
  }
  CHECK(before < -0.5);
  largest_step = 0;
  run(200, false);
  CHECK(kit.stale());
  CHECK(before == 0);
  CHECK(largest_step < 0.05);
  run(100, true);
  CHECK_FALSE(kit.stale());
  CHECK(largest_step < 0.05);
}

TEST_CASE("with the clutch pressed the needle rests, and goes on from where it rested") {
  Loop loop(1000, 0, {300, 1, 0.5, 0.1, 1});
  loop.go(0.02, 0.05, 0.5);
  const double rested = loop.answer.base.position[0];
  loop.clutch = true;
  loop.go(-0.01, 0.05, 0.5);
  CHECK(loop.answer.base.position[0] == rested);
  loop.clutch = false;
  loop.step(loop.meant, 0);
  CHECK(loop.answer.base.position[0] == doctest::Approx(rested).epsilon(1e-9));
  loop.go(0, 0.05, 0.5);
  CHECK(loop.answer.base.position[0] == doctest::Approx(rested + 0.01).epsilon(0.02));
}

TEST_CASE("no sample and no message allocates") {
  Loop loop(1000, 5e-3, {300, 1, 0.5, 0.1, 0.01});
  loop.step(0, 0);
  allocations = 0;
  counting = true;
  loop.go(0.03, 0.05, 0.1);
  counting = false;
  CHECK(allocations == 0);
}

TEST_CASE("options out of range are refused by their name") {
  KitOptions options;
  options.workspace.scale = 0;
  CHECK_THROWS_WITH_AS(Kit({}, options), "workspace.scale: expected > 0, found 0.000000", std::invalid_argument);
  options = {};
  options.transient = {0.3, 0.02};
  CHECK_THROWS_WITH_AS(Kit(Loop::with_rate(100), options),
                       "transient.length: expected at least 0.040000 s, 4 samples of the device, found 0.020000",
                       std::invalid_argument);
  CHECK_NOTHROW(Kit(Loop::with_rate(200), options));
  options.transient = {-1, 0.02};
  CHECK_THROWS_AS(Kit({}, options), std::invalid_argument);
  DeviceProperties late;
  late.delay = 0.9;
  CHECK_THROWS_AS(Kit(late, {}), std::invalid_argument);
}

TEST_CASE("a simulated handle falls to the closed form of a damped mass under a steady force") {
  SimulatedHandle handle({{0.1, 2, 0, 0, 10}, {}, {0, 0, 0}});
  handle.write({{1, 0, 0}});
  handle.advance(0.2);
  const double speed = 0.5 * (1 - std::exp(-2 * 0.2 / 0.1));
  CHECK(handle.velocity()[0] == doctest::Approx(speed).epsilon(2e-3));
  handle.write({{100, 0, 0}});  // saturates
  handle.advance(50e-6);
  CHECK(handle.acting()[0] == doctest::Approx(10));
}

TEST_CASE("friction holds a handle until it is pushed harder, and the encoder has steps") {
  SimulatedHandle handle({{0.1, 1, 0.2, 1e-3, 10}, {}, {0, 0, 0}});
  handle.write({{0.19, 0, 0}});
  handle.advance(0.1);
  CHECK(handle.position()[0] == 0);
  handle.write({{0.5, 0, 0}});
  handle.advance(0.1);
  CHECK(handle.position()[0] > 1e-3);
  CHECK(std::remainder(handle.measured()[0], 1e-3) == doctest::Approx(0).scale(1e-9));
}

TEST_CASE("the simulated hand goes in, rests, comes back, and begins again") {
  const HandMotion motion{0.04, 0.02, 0.5};
  CHECK(meant_at(motion, 0.3).place == 0);
  CHECK(meant_at(motion, 1.5).place == doctest::Approx(0.02));
  CHECK(meant_at(motion, 1.5).speed == doctest::Approx(0.02));
  CHECK(meant_at(motion, 2.7).place == doctest::Approx(0.04));
  CHECK(meant_at(motion, 4).place == doctest::Approx(0.02));
  CHECK(meant_at(motion, 5.3).place == doctest::Approx(0));
}
