// SPDX-License-Identifier: MIT
// The passivity observer, an account of the energy at the device, and the controller, which renders no force that the
// account cannot pay for. Time-domain passivity control after Hannaford and Ryu 2002 (IEEE Trans. Robotics and
// Automation 18(1)). Instead of adding a damper when energy has already been made, which chatters, it bounds the force
// beforehand, as the energy-bounding algorithm of Kim and Ryu 2010 (Int. J. Robotics Research 29(6)) does; the account
// has a ceiling so that what friction ate long ago pays for nothing today, the trouble that Ryu, Preusche, Hannaford
// and Hirzinger 2005 (IEEE Trans. Control Systems Technology 13(5)) solve by a reference energy.
//
// S is the account, K the diagonal of k_felt (coupling.h), F the wrench rendered between two samples and D the device's
// displacement in that time:
//
//   S <- S - F'D + (1/2 + n) D'K D,       then F is scaled down until  1/2 F'K^-1 F <= S.
//
// n samples of delay in the device's loop; F is the wrench that acted, n samples old. The last term is what the
// device's own damping eats: by Cauchy and Schwarz it eats at least D'b D/T in a sample, and K <= b/(T/2 + n T). In a
// sample that comes late, after l T, it eats no more than 1/l of that for the same way: the term is divided by l.
//
// For n = 0, S stays >= 0 whatever force the rest of the loop asks for: with 1/2 F'K^-1 F <= S before the sample,
//
//   S_after >= 1/2 F'K^-1 F - F'D + 1/2 D'K D = 1/2 |K^(-1/2) F - K^(1/2) D|^2 >= 0.
//
// So device and kit together never give more than they took: they are passive, for any tissue, delay and loss of
// messages. The bound on K is Colgate's. For n > 0, forces on their way to the device can take S below zero, and so can
// a late sample; nothing is rendered then until the hand has paid it back, which bounds what can be made in all.
//
// A spring of stiffness K is rendered unchanged, and so is every softer one: the work of the hand covers it.
#pragma once

#include <array>

#include "client/haptics/coupling.h"
#include "client/haptics/vectors.h"

namespace acus::haptics {

class Passivity {
 public:
  static constexpr int kMostDelay = 256;  // samples

  // `delay` in samples, 0 to kMostDelay - 1.
  Passivity(const Coupling& coupling, int delay);

  // Observes a sample: the device has moved by `displacement` (m, rad) since the last one, in `periods` sample times.
  void observe(const Vector6& displacement, double periods = 1);

  // The wrench to render now, of the one that is wanted. `stored` (J) is what the model's springs hold at it: more than
  // that, and a reserve, the account does not keep.
  Wrench control(const Wrench& wanted, double stored);

  double account() const { return account_; }    // J
  // J, >= 0, kept from the hand: what wanted forces would have brought more.
  double withheld() const { return withheld_; }
  double given() const { return given_; }        // J, net, that the rendered forces brought to the device

  // For what jitters while nothing moves: an account that is this much above what is stored.
  static constexpr double kReserveForce = 0.05;  // N: half its square over k_felt
  static constexpr double kReserveShare = 0.1;   // of what is stored

 private:
  double cost(const Vector6& wrench) const;  // 1/2 F'K^-1 F

  Vector6 stiffness_;  // K
  int delay_;
  std::array<Vector6, kMostDelay> rendered_{};  // the newest kMostDelay, round
  std::array<Vector6, kMostDelay> wanted_{};
  int newest_ = 0;
  double account_ = 0;
  double withheld_ = 0;
  double given_ = 0;
};

// The delay of a device in samples. Throws std::invalid_argument if there are too many.
int samples_of_delay(const DeviceProperties& properties);

}  // namespace acus::haptics
