// SPDX-License-Identifier: GPL-3.0-or-later
// Devices with one fault each, which acus-haptic --verify has to find, in simulated time.
#include "client/haptics/program/verification.h"

#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <sstream>
#include <string>

#include "client/haptics/program/obedient_device.h"
#include "client/haptics/simulated_device.h"

using namespace acus::haptics;

namespace {

// A handle that is as it should be, and a driver that reports and pushes otherwise.
class FaultyDevice : public ObedientDevice {
 public:
  using ObedientDevice::ObedientDevice;

  Reading read() override {
    Reading reading = ObedientDevice::read();
    reading.pose.position = report(reading.pose.position);
    return reading;
  }
  void write(const Wrench& wrench) override {
    most = std::max(most, norm(wrench.force));
    last = norm(wrench.force);
    ObedientDevice::write({push(wrench.force), {}});
  }

  std::function<Vector3(const Vector3&)> report = [](const Vector3& place) { return place; };
  std::function<Vector3(const Vector3&)> push = [](const Vector3& force) { return force; };
  double most = 0, last = 0;  // N
};

struct Bench {
  Bench() : device(handle, told_of(handle, 1000), [this] { return now; }) {}

  bool verify(const std::string& axes = "x,y,z") {
    std::ostringstream out;
    const DeviceProperties properties = device.open();
    Verification verification(device, properties, rotation_of_axes(axes),
                              {[this] { return now; }, [this](double until) { now = until; }}, out);
    verification.on_request = [this](const Vector3& way) { device.request(way); };
    const bool good = verification.run().value();
    said = out.str();
    return good;
  }

  SimulatedHandleProperties handle{{}, {}, kGrips[1].hand};
  double now = 0;  // s
  FaultyDevice device;
  std::string said;
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a device that is as it should be passes, and is pushed by no more than a newton") {
  Bench bench;
  CHECK(bench.verify());
  CHECK_MESSAGE(!contains(bench.said, "WRONG"), bench.said);
  CHECK(bench.device.most <= 1);
  CHECK(bench.device.most > 0.2);
  CHECK(bench.device.last == 0);
}

TEST_CASE("turned axes are told, with the option that mends them, and pass with it") {
  // Of the device: y to the right, x ahead... as vectors: what its driver reports of a place.
  const auto report = [](const Vector3& p) { return Vector3{{-p[1], p[0], p[2]}}; };
  const auto push = [](const Vector3& f) { return Vector3{{f[1], -f[0], f[2]}}; };
  Bench bench;
  bench.device.report = report;
  bench.device.push = push;
  CHECK_FALSE(bench.verify());
  CHECK_MESSAGE(contains(bench.said, "--axes=y,-x,z"), bench.said);
  CHECK(bench.device.most == 0);  // what is not understood is not pushed
  Bench mended;
  mended.device.report = report;
  mended.device.push = push;
  CHECK_MESSAGE(mended.verify("y,-x,z"), mended.said);
}

TEST_CASE("a mirrored axis, another unit, a frozen handle: each is named, and nothing is pushed") {
  struct Fault {
    std::function<Vector3(const Vector3&)> report;
    const char* said;
  };
  for (const Fault& fault : {Fault{[](const Vector3& p) {
                                     return Vector3{{p[0], -p[1], p[2]}};
                                   },
                                   "mirrored"},
                             Fault{[](const Vector3& p) { return 1e3 * p; }, "not the metre"},
                             Fault{[](const Vector3& p) { return 1e-3 * p; }, "not the metre"},
                             Fault{[](const Vector3&) { return Vector3{}; }, "not the metre"}}) {
    Bench bench;
    bench.device.report = fault.report;
    CHECK_FALSE(bench.verify());
    CHECK_MESSAGE(contains(bench.said, fault.said), bench.said);
    CHECK(bench.device.most == 0);
  }
}

TEST_CASE("a slow device and one with coarser steps than it states are told") {
  Bench slow;
  slow.device.report = [&slow, held = Vector3{}, next = 0.0](const Vector3& p) mutable {
    if (slow.now >= next) held = p, next = slow.now + 0.01;
    return held;
  };
  CHECK_FALSE(slow.verify());
  CHECK_MESSAGE(contains(slow.said, "WRONG   rate: 100 new"), slow.said);
  Bench coarse;
  coarse.device.report = [](const Vector3& p) {
    Vector3 rounded;
    for (int i = 0; i < 3; ++i) rounded[i] = 5e-5 * std::round(p[i] / 5e-5);
    return rounded;
  };
  CHECK_FALSE(coarse.verify());
  CHECK_MESSAGE(contains(coarse.said, "WRONG   resolution: steps of 50 µm"), coarse.said);
}

TEST_CASE("a force of the wrong sign, along another axis, or none at all is found before it is a newton") {
  Bench inverted;
  inverted.device.push = [](const Vector3& f) { return -f; };
  CHECK_FALSE(inverted.verify());
  CHECK_MESSAGE(contains(inverted.said, "WRONG   force along x"), inverted.said);
  CHECK_MESSAGE(contains(inverted.said, "along -x"), inverted.said);
  CHECK(inverted.device.most < 1);
  CHECK(inverted.device.last == 0);
  Bench swapped;
  swapped.device.push = [](const Vector3& f) { return Vector3{{f[0], f[2], f[1]}}; };
  CHECK_FALSE(swapped.verify());
  CHECK_MESSAGE(contains(swapped.said, "WRONG   force along y"), swapped.said);
  Bench none;
  none.device.push = [](const Vector3&) { return Vector3{}; };
  CHECK_FALSE(none.verify());
  CHECK_MESSAGE(contains(none.said, "less than 4 mm"), none.said);
}

TEST_CASE("a check that is interrupted says nothing of the device, and leaves no force") {
  for (const double at : {0.3, 5.0, 13.5}) {
    CAPTURE(at);
    Bench bench;
    std::atomic<bool> interrupt = false;
    std::ostringstream out;
    const DeviceProperties properties = bench.device.open();
    Verification verification(bench.device, properties, {},
                              {[&] { return bench.now; },
                               [&](double until) {
                                 bench.now = until;
                                 interrupt = until >= at;
                               }},
                              out, &interrupt);
    verification.on_request = [&](const Vector3& way) { bench.device.request(way); };
    CHECK_FALSE(verification.run());
    CHECK_MESSAGE(!contains(out.str(), "WRONG"), out.str());
    CHECK(contains(out.str(), "Interrupted"));
    CHECK(bench.device.last == 0);
  }
}

TEST_CASE("axes are a rotation, or refused by a sentence") {
  const Vector3 place{{1, 2, 3}};
  CHECK(rotation_of_axes("x,y,z") * place == place);
  for (const auto& [axes, turned] : {std::pair<std::string, Vector3>{"y,-x,z", {{2, -1, 3}}},
                                     {"-z,y,x", {{-3, 2, 1}}},
                                     {"-x,-y,z", {{-1, -2, 3}}},
                                     {"z,x,y", {{3, 1, 2}}},
                                     {"x,-y,-z", {{1, -2, -3}}},
                                     {"-x,y,-z", {{-1, 2, -3}}}}) {
    CAPTURE(axes);
    CHECK(norm(rotation_of_axes(axes) * place - turned) < 1e-12);
  }
  for (const char* axes : {"", "x,y", "x,x,z", "x,-y,z", "x,y,w", "x,y,z,x", "x,y,z,"}) {
    CAPTURE(axes);
    CHECK_THROWS_AS(rotation_of_axes(axes), std::invalid_argument);
  }
}
