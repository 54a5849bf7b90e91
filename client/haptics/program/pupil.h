// SPDX-License-Identifier: MIT
// The side of a shared needle that joins a teacher's session (teacher.h): a device, and no server of its own. In the
// teacher's time if that one is in lockstep, otherwise in real time.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "client/haptics/delay_line.h"
#include "client/haptics/program/device_list.h"
#include "client/haptics/program/partner_link.h"
#include "client/haptics/shared_hand.h"

namespace acus::haptics {

struct PupilOptions {
  std::string endpoint;
  DeviceChoice device;
  Quaternion turned;  // from the device's frame to that of device.h
  SharedHandOptions hand;
  LinkDelay network;    // simulated: both ways together, loss of each
  double duration = 0;  // s, 0: until the teacher ends
  client::Timeout timeout{10'000};
  const std::atomic<bool>* interrupt = nullptr;
};

struct PupilSample {
  double time = 0;     // s
  Pose device;         // device frame
  Wrench rendered;     // N, N m, likewise
  double share = 0;    // of the pupil
  Vector6 ahead;       // m, rad, of the teacher's way before this one
  double account = 0;  // J
};

class Pupil {
 public:
  explicit Pupil(const PupilOptions& options) : options_(options), link_(options.endpoint, PartnerLink::Side::pupil) {}

  // Runs once. Throws client::ClientError or DeviceError; the device is let go in any case.
  void run();

  std::function<void(const PupilSample&)> on_sample = [](const PupilSample&) {};
  std::uint64_t samples() const { return samples_; }
  double largest_force() const { return largest_force_; }  // N
  double withheld() const { return withheld_; }            // J, see Passivity
  double given() const { return given_; }                  // J, likewise
  double duration() const { return now_; }                 // s

 private:
  std::optional<TeacherNews> wait_for_teacher();
  void loop_in_lockstep(Device& device, SharedHand& hand, TeacherNews news);
  void loop_in_real_time(Device& device, SharedHand& hand, double rate);
  void hear(const TeacherNews& news);
  void sample(Device& device, SharedHand& hand);
  bool continues() const;

  PupilOptions options_;
  PartnerLink link_;
  DelayLine<TeacherNews> there_{{}};
  DelayLine<PupilNews> back_{{}};
  std::optional<TeacherNews> teacher_;  // newest that the network has delivered
  PupilNews told_;                      // likewise, of this side
  Pose start_, before_;
  Vector6 offset_;  // of this way, to begin where the teacher is
  bool first_ = true;
  double now_ = 0, heard_ = 0, sampled_ = 0;  // s
  std::uint64_t samples_ = 0;
  double largest_force_ = 0, withheld_ = 0, given_ = 0;
};

}  // namespace acus::haptics
