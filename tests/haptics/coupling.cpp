// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/haptics/coupling.h"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

using namespace acus::haptics;

namespace {

// The least damping that keeps a spring k, n samples late, passive: Colgate and Schenkel's condition, on a fine grid of
// frequencies.
double least_damping(double k, double sample_time, int n) {
  double most = 0;
  for (int i = 1; i <= 20000; ++i) {
    const double angle = std::numbers::pi * i / 20000;
    const std::complex<double> z = std::polar(1.0, angle);
    const double need = sample_time / 2 * ((1.0 - 1.0 / z) * k * std::pow(z, -n)).real() / (1 - std::cos(angle));
    most = std::max(most, need);
  }
  return most;
}

}  // namespace

TEST_CASE("the bound with and without delay is that of Colgate and Schenkel's condition") {
  constexpr double kDamping = 1.5, kSampleTime = 1e-3;
  for (const int n : {0, 1, 5, 20}) {
    const double k = passive_stiffness(kDamping, kSampleTime, n * kSampleTime);
    CHECK(least_damping(k, kSampleTime, n) == doctest::Approx(kDamping).epsilon(1e-4));
  }
}

TEST_CASE("the rule takes the smallest of its bounds") {
  DeviceProperties device;
  device.translation = {0.1, 1, 0.05, 10e-6, 10};
  device.rate = 1000;
  CHECK(coupling_of(device).translation == doctest::Approx(0.9 * 2000));  // damping
  device.translation.resolution = 100e-6;
  CHECK(coupling_of(device).translation == doctest::Approx(0.9 * 1000));  // friction over resolution
  device.translation.resolution = 0;
  device.delay = 9.5e-3;
  CHECK(coupling_of(device).translation == doctest::Approx(0.9 * 100));  // delay
  device.delay = 0;
  device.rate = 100;
  device.translation.mass = 0.01;
  CHECK(coupling_of(device).translation == doctest::Approx(0.9 * 0.01 * std::pow(std::numbers::pi / 0.04, 2)));  // mass
  device.translation.largest_force = 0;
  CHECK(coupling_of(device).translation == 0);
}

TEST_CASE("the virtual coupling is twice as stiff as what is felt, but for what friction holds of an encoder's step") {
  DeviceProperties device;
  device.rate = 1000;
  CHECK(coupling_of(device).translation_spring == doctest::Approx(2 * 1800));
  CHECK(coupling_of(device).rotation_spring == 0);  // renders none
  device.rate = 4000;
  CHECK(coupling_of(device).translation == doctest::Approx(7200));
  CHECK(coupling_of(device).translation_spring == doctest::Approx(0.9 * 2 * 0.05 / 10e-6));
  device.translation.resolution = 20e-6;
  CHECK(coupling_of(device).translation_spring == doctest::Approx(coupling_of(device).translation));
}

TEST_CASE("properties out of range are refused by their name") {
  DeviceProperties device;
  device.translation.damping = 0;
  CHECK_THROWS_WITH_AS(validate(device), "translation.damping: expected > 0, found 0.000000", std::invalid_argument);
  device = {};
  device.rate = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(validate(device), std::invalid_argument);
}
