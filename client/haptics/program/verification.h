// SPDX-License-Identifier: MIT
// Checks a device before its first session (acus-haptic --verify): asks a person for six motions of the handle, then
// pushes the handle gently along each axis. Proves axes, signs, unit, rate and resolution of what the device reports,
// and axes and signs of its force. Needs no server.
//
// Frame that a device has to report in, as seen by the person who holds the handle: x ahead, y to the left, z up.
// A device with other axes is turned by --axes, which the check suggests.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "client/haptics/device.h"

namespace acus::haptics {

// The rotation that takes a device's coordinates to the frame above, from three of x, y, z, -x, -y, -z, separated by
// commas: those of the device that are ahead, left and up. Throws std::invalid_argument for what is no rotation.
Quaternion rotation_of_axes(const std::string& axes);

class Verification {
 public:
  // Time, s: of a real clock, or simulated.
  struct Clock {
    std::function<double()> now;
    std::function<void(double)> sleep_until;
  };

  // The device is open. `turned` as of rotation_of_axes.
  Verification(Device& device, const DeviceProperties& properties, const Quaternion& turned, Clock clock,
               std::ostream& out, const std::atomic<bool>* interrupt = nullptr);

  // Whether the device may be used as it is; nothing if it was interrupted before that is known. Leaves it without
  // force. Throws DeviceError.
  std::optional<bool> run();

  // Told what is asked for: a way of the handle in the frame above (m), zero for rest. For a simulated hand.
  std::function<void(const Vector3& way)> on_request = [](const Vector3&) {};

  static constexpr double kWay = 0.05;                      // m, that is asked for
  static constexpr double kLeastWay = 0.02;                 // m, that counts as a motion,
  static constexpr double kStill = 1e-3, kStillTime = 0.4;  // m, s: ended by such a rest
  static constexpr double kLongest = 0.25;                  // m, beyond which the unit is wrong
  static constexpr double kPatience = 20;                   // s, for each motion
  static constexpr double kForce = 1, kRamp = 2;            // N at most, s to get there
  static constexpr double kPushed = 4e-3;                   // m, that is enough to see where a force goes
  static constexpr double kAligned = 0.8;                   // cosine, of a way with an axis

 private:
  struct Motion {
    Vector3 from, to;     // m
    double farthest = 0;  // m, from the start
    bool came = false;
  };
  Vector3 read();
  bool stopped() const { return interrupt_ && *interrupt_; }
  Motion wait_for_motion(double least_way);
  bool check_rest();
  bool check_motions();
  bool judge_axes(const std::array<Vector3, 6>& ways);
  bool check_rate();
  bool check_resolution();
  bool check_forces();
  bool push(int axis);
  bool tell(bool good, const std::string& what, const std::string& found);

  Device& device_;
  DeviceProperties properties_;
  Quaternion turned_;
  Clock clock_;
  std::ostream& out_;
  const std::atomic<bool>* interrupt_;
  double due_ = 0;               // s, of the next sample
  Vector3 place_;                // m, newest, in the frame above
  Vector3 raw_;                  // m, newest, as the device has it
  double least_step_ = 0;        // m, smallest change of a coordinate seen; 0: none
  std::vector<double> changes_;  // s, when a reading was another one than the last
};

}  // namespace acus::haptics
