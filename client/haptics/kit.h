// SPDX-License-Identifier: MIT
// The loop of a haptic device on a needle of Acus, one call a sample, without allocation, locks or clocks:
//
//   Kit kit(properties, options);
//   kit.begin(device_pose, base_pose);      // both stand for each other from now on
//   every sample:
//     if (a message came) kit.take(model);
//     if (an event came that is felt) kit.begin_transient();
//     const Kit::Answer answer = kit.step({device_pose, clutch});
//     device.write(answer.on_hand);  send(answer.base);
//
// A needle that presses on a stiff surface is thrown off it now and then, by its own inertia. A message of such a tick,
// in the air just behind the surface, does not open the way: the surface of the last message with contact stays ahead
// until the needle is seen in the air beyond it, or elsewhere.
//
// A sample goes through: registration, the local model's answer through the virtual coupling, the ramp of what is stale
// or parted, limits, the passivity controller. Only the last can make the device safe, so it comes last; all before it
// make it feel right. docs/haptics.md says what each costs. Devices hold their own weight.
//
// The needle goes with the device at once, as the newest model says. What a new model changes about that, it changes
// not at once: with p_new and p_old what both models answer to the same device, the needle is sent to
//
//   p = p_new - e,   e = p_new - (p_old - e_old) as a model comes,   then e <- (1 - s) e at every sample,
//
// s = 1 - exp(-T/tau), at most 1/2, with tau of two ticks of the server. For needle and tissue answer a place that they
// are sent to with inertia and viscosity as well, which are gone a tick later: a needle that followed each model at
// once would be thrown to and fro between two ticks, however still the device is held. For inertia alone, a mass m with
// A = m/h² that is sent where Kc (x - p) + F = 0 has it, any delay is stable if s <= 1/2 per tick: the gain from one
// message to the next is |2 - z^-1| s/|1 - (1 - s) z^-1|, which is then at most one.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "client/haptics/coupling.h"
#include "client/haptics/local_response.h"
#include "client/haptics/moving_stiffness.h"
#include "client/haptics/passivity.h"
#include "client/haptics/ramp.h"
#include "client/haptics/registration.h"
#include "client/haptics/transient.h"

namespace acus::haptics {

struct KitOptions {
  Workspace workspace;
  double stale_after = 0.1;    // s, > 0, without a message, after which nothing more is felt,
  double ramp = 0.05;          // s, >= 0, in which the force ends, and comes back
  double force_growth = 2000;  // N/s, > 0, at most; torques in proportion to their limit
  TransientShape transient;    // at punctures, releases and crossings
  double fast = 0.5;           // m/s, > 0, of the device: while it moves faster
  double fast_force = 3;       // N, >= 0, is the most that is felt, as of a hand that runs into bone
};

// Throws std::invalid_argument, which names the field.
void validate(const KitOptions& options);

class Kit {
 public:
  // Throws std::invalid_argument.
  explicit Kit(const DeviceProperties& properties, const KitOptions& options = {});

  // From now on the device's pose means this pose of the needle's base; nothing is felt until a model comes.
  void begin(const Pose& device, const Pose& base);

  // The newest model. One of a tick that is older than the last is left out.
  void take(const LocalModel& model);

  // The needle has gone through a surface or left it: the transient of the options begins. It is paid for like every
  // force, from an account that keeps as much for it.
  void begin_transient() { transient_.begin(); }

  struct Sample {
    Pose device;          // device frame
    bool clutch = false;  // pressed: the needle rests, the device moves freely
    double elapsed = 0;   // s since the last sample; 0: the device's sample time. A late one is to be told
  };
  struct Answer {
    Wrench on_hand;     // N, N m, device frame, to render until the next sample
    Pose base;          // where the needle's base is to go, world
    std::uint64_t seq;  // number of this command, counted from 1: models tell which one they know of
    Wrench wanted;      // what would be rendered without limits and controller, device frame
    double stored = 0;  // J, that springs of tissue and coupling hold of it, at the device
  };
  Answer step(const Sample& sample);

  const Coupling& coupling() const { return coupling_; }
  const Passivity& passivity() const { return passivity_; }
  Wrench at_device(const Wrench& at_base) const { return registration_.at_device(at_base); }
  bool stale() const { return age_ > options_.stale_after; }

 private:
  void observe(const Pose& device, double elapsed);
  Vector3 transient(double sample_time);
  double kept_for_transient(const Wrench& rendered) const;
  bool parted(const Sample& sample);
  LocalModel learnt(const LocalModel& model);
  bool left_contact(const LocalModel& model) const;
  LocalModel with_contact(const LocalModel& model);
  Pose place_of(const Pose& target, const Pose& proxy, double sample_time);
  void remember(const Pose& base);

  DeviceProperties properties_;
  KitOptions options_;
  Coupling coupling_;
  Registration registration_;
  LocalResponse response_, previous_;
  Passivity passivity_;
  MovingStiffness moving_;
  std::optional<LocalModel> contact_;  // newest on a surface, until one shows that this has gone
  Ramp ramp_;
  Transient transient_;
  Pose device_before_, base_before_;
  Vector6 behind_;            // e: what the needle is still behind response_, m and rad
  bool newly_taken_ = false;  // a model came since the last sample, previous_ is the one before
  double tick_time_ = 1e-3;   // s, of the server
  double time_ = 0;           // s, of the newest model
  Wrench before_;             // rendered
  std::uint64_t epoch_ = 0, tick_ = 0;
  double age_ = 1e9;     // s since the last model came
  double speed_ = 0;     // m/s, of the device, smoothed
  double sticking_ = 0;  // N/m, axial stiffness of the last tick that had one
  static constexpr int kKept = 512;
  std::array<Pose, kKept> sent_{};  // the newest commands, round, by their number
  std::uint64_t seq_ = 0;           // of the newest
  bool model_stale_ = false;
  bool clutched_ = false;
};

}  // namespace acus::haptics
