// SPDX-License-Identifier: MIT
// How stiff a device may feel, and the virtual coupling that keeps a stiffer tissue from being felt stiffer: the rule.
//
// A device of damping b (N s/m) that renders H(z) with sampling time T and holds each force until the next is passive,
// whoever holds it, if and only if
//
//   b > T/2 Re{(1 - e^{-jwT}) H(e^{jwT})}/(1 - cos wT)  for all w up to pi/T
//
// (Colgate and Schenkel 1997, J. Robotic Systems 14(1)). For a spring k with damping B this is b > k T/2 + |B|. For a
// spring whose force comes n samples late, H = k z^{-n}, the right side is k T/2 sin((n + 1/2) wT)/sin(wT/2), largest
// for slow motion: b > k (T/2 + d) with d = n T. A position that is known to a step D makes energy that Coulomb
// friction c takes up if k <= 2 c/D (Abbott and Okamura 2005, IEEE Trans. Robotics 21(5)). And a spring that a sampled
// force shall follow needs some eight samples in a period of its oscillation with the device's mass m:
// k <= m (pi/(4 T))^2.
//
// The kit renders no damping, B = 0. Of the smallest of these bounds it takes kShare:
//
//   k_felt = 0.9 min(b/(T/2 + d), 2 c/D, m (pi/(4 T))²)    on each axis of translation and of rotation,
//
// and the virtual coupling between device and needle is a spring of kCoupling k_felt: in series with a tissue of
// stiffness k it is felt as 2 k k_felt/(k + 2 k_felt), at least two thirds of the smaller of k and k_felt. What the
// series would exceed k_felt by, for k > 2 k_felt, the passivity controller holds back (passivity.h). The coupling is
// no stiffer than kShare 2 c/D, at least k_felt: a step of the encoder moves it by D, and friction has to hold the
// handle against what that changes.
//
// d is the delay within the device's own loop alone. That of the network does not enter: the local model answers at
// once (local_response.h), and what it gets wrong the passivity controller finds.
#pragma once

#include <stdexcept>
#include <string>

namespace acus::haptics {

// Of translation (N, m) or of rotation (N m, rad). What is guaranteed, rather less than more: the coupling relies on
// it.
struct AxisProperties {
  double mass = 0.1;          // kg or kg m², > 0
  double damping = 1;         // N s/m or N m s/rad, > 0, of the device alone or with the lightest hand that holds it
  double friction = 0.05;     // N or N m, >= 0, Coulomb
  double resolution = 10e-6;  // m or rad, >= 0, of the encoder; 0: exact
  double largest_force = 10;  // N or N m, >= 0, that it can exert; 0: renders none
};

struct DeviceProperties {
  AxisProperties translation;
  AxisProperties rotation{5e-5, 1e-3, 1e-4, 1e-4, 0};
  double rate = 1000;  // Hz, > 0, of its loop
  double delay = 0;    // s, >= 0, from the reading of a pose to the force that answers it, besides the holding
};

// Throws std::invalid_argument, which names the field.
void validate(const DeviceProperties& properties);

inline constexpr double kShare = 0.9;
inline constexpr double kCoupling = 2;

// The largest passive stiffness by Colgate and Schenkel, with a delay (N/m or N m/rad).
double passive_stiffness(double damping, double sample_time, double delay);

// k_felt of an axis; 0 for one that renders no force.
double felt_stiffness(const AxisProperties& axis, double sample_time, double delay);

// Of the virtual coupling of such an axis.
double coupling_spring(const AxisProperties& axis, double felt_stiffness);

// What the rule gives for a device.
struct Coupling {
  double translation = 0;         // k_felt, N/m
  double rotation = 0;            // k_felt, N m/rad
  double translation_spring = 0;  // N/m, of the virtual coupling
  double rotation_spring = 0;     // N m/rad
};
Coupling coupling_of(const DeviceProperties& properties);

}  // namespace acus::haptics
