// SPDX-License-Identifier: MIT
#include "client/haptics/coupling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace acus::haptics {

namespace {

void require(bool holds, const std::string& field, const char* range, double found) {
  if (holds && std::isfinite(found)) return;
  throw std::invalid_argument(field + ": expected " + range + ", found " + std::to_string(found));
}

void validate(const AxisProperties& axis, const std::string& name) {
  require(axis.mass > 0, name + ".mass", "> 0", axis.mass);
  require(axis.damping > 0, name + ".damping", "> 0", axis.damping);
  require(axis.friction >= 0, name + ".friction", ">= 0", axis.friction);
  require(axis.resolution >= 0, name + ".resolution", ">= 0", axis.resolution);
  require(axis.largest_force >= 0, name + ".largest_force", ">= 0", axis.largest_force);
}

// 2 c/D.
double encoder_bound(const AxisProperties& axis) {
  return axis.resolution > 0 ? 2 * axis.friction / axis.resolution : std::numeric_limits<double>::infinity();
}

}  // namespace

void validate(const DeviceProperties& properties) {
  validate(properties.translation, "translation");
  validate(properties.rotation, "rotation");
  require(properties.rate > 0, "rate", "> 0", properties.rate);
  require(properties.delay >= 0 && properties.delay <= 1, "delay", "0 to 1", properties.delay);
}

double passive_stiffness(double damping, double sample_time, double delay) {
  return damping / (sample_time / 2 + delay);
}

double felt_stiffness(const AxisProperties& axis, double sample_time, double delay) {
  if (axis.largest_force == 0) return 0;
  const double turn = std::numbers::pi / (4 * sample_time);
  const double bound = std::min(passive_stiffness(axis.damping, sample_time, delay), axis.mass * turn * turn);
  return kShare * std::min(bound, encoder_bound(axis));
}

double coupling_spring(const AxisProperties& axis, double felt_stiffness) {
  return std::clamp(kShare * encoder_bound(axis), felt_stiffness, kCoupling * felt_stiffness);
}

Coupling coupling_of(const DeviceProperties& properties) {
  const double sample_time = 1 / properties.rate;
  const double translation = felt_stiffness(properties.translation, sample_time, properties.delay);
  const double rotation = felt_stiffness(properties.rotation, sample_time, properties.delay);
  return {translation, rotation, coupling_spring(properties.translation, translation),
          coupling_spring(properties.rotation, rotation)};
}

}  // namespace acus::haptics
