// SPDX-License-Identifier: MIT
// The side of a shared needle that holds it at the server: joins its own handle's way with the pupil's (shared_hand.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "client/haptics/device.h"
#include "client/haptics/kit.h"
#include "client/haptics/program/partner_link.h"
#include "client/haptics/shared_hand.h"

namespace acus::haptics {

struct SharingOptions {
  std::string endpoint;             // empty: not shared
  std::atomic<double>* share = {};  // of the teacher, 0 to 1; may change at any time; null: one half
  SharedHandOptions hand;
};

class Teacher {
 public:
  // `turned`: from the device's frame to that of device.h. Throws client::ClientError.
  Teacher(const SharingOptions& options, const DeviceProperties& properties, const Quaternion& turned, bool lockstep);
  ~Teacher();  // tells the pupil
  Teacher(const Teacher&) = delete;
  Teacher& operator=(const Teacher&) = delete;

  // In lockstep: until a pupil is there, or a signal came; later it is lost if it takes longer for an answer. Throws
  // client::Vanished.
  void wait_for_pupil(client::Timeout timeout, const std::atomic<bool>* interrupt);

  // From now on both ways are nothing.
  void begin(const Pose& handle);

  // A sample at `now`, `elapsed` after the last (s): the kit's answer on the joint way, with what this hand is to feel.
  Kit::Answer step(Kit& kit, const Device::Reading& reading, double now, double elapsed);

  const SharedHand& hand() const { return hand_; }
  const Wrench& felt() const { return news_.felt; }  // N, N m, of one hand alone on the joint way

  // A pupil has come, or is there no longer.
  std::function<void(bool there)> on_pupil = [](bool) {};

  static constexpr double kStale = 0.1;        // s without news, after which the pupil is not there
  static constexpr double kShareChange = 2.0;  // 1/s, at most

 private:
  void hear(double now);
  void lose_pupil();
  bool has_pupil(double now) const { return pupil_ && now - heard_ <= kStale; }

  SharingOptions options_;
  Quaternion turned_;
  bool lockstep_;
  client::Timeout patience_{0};  // in lockstep
  double sample_time_;           // s
  PartnerLink link_;
  SharedHand hand_;
  Pose start_, before_;
  TeacherNews news_;
  std::optional<PupilNews> pupil_;  // of this origin
  double heard_ = 0;                // s, when
  double share_ = 1;                // in use
  bool joint_ = false;              // there was a pupil at the last sample
};

}  // namespace acus::haptics
