// SPDX-License-Identifier: MIT
// A device on a needle of a server, sample after sample: in real time on absolute deadlines of the steady clock, or
// with a server in lockstep, in simulation time, where the same run gives the same numbers.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/haptics/delay_line.h"
#include "client/haptics/kit.h"
#include "client/haptics/message.h"
#include "client/haptics/program/device_list.h"
#include "client/haptics/program/force_model.h"
#include "client/haptics/program/plain_rendering.h"
#include "client/haptics/program/rest_check.h"
#include "client/haptics/program/teacher.h"
#include "client/link/client.h"

namespace acus::haptics {

struct SessionOptions {
  std::string commands = protocol::kDefaultCommandsEndpoint;
  std::string states = protocol::kDefaultStatesEndpoint;
  std::optional<client::CurveKeys> keys;
  std::string needle;  // empty: the scene's first
  DeviceChoice device;
  KitOptions kit;  // its workspace's axes are turned so that the device's x is the needle's
  bool with_kit = true;
  SharingOptions sharing;  // with a pupil; needs the kit
  LinkDelay network;    // simulated, added to the real one: delay and jitter of both ways together, loss of each
  double duration = 0;  // s, 0: until it is interrupted
  client::Timeout timeout{10'000};
  std::atomic<bool>* interrupt = nullptr;
};

// Of one sample.
struct SampleRecord {
  double time = 0;      // s since the start
  Pose device;          // device frame
  Pose base;            // world, commanded
  Wrench wanted;        // N, N m, at the device, before limits and controller
  Wrench rendered;      // likewise
  Wrench server;        // likewise, newest that came: of a needle that stands still; not limited
  double account = 0;   // J
  double withheld = 0;  // J
};

struct SessionResults {
  std::string scene, needle, topic;
  bool lockstep = false, with_kit = true;
  bool shared = false;  // with another hand: force and energy are of this one, the force at rest is of both
  double duration = 0;  // s
  std::uint64_t samples = 0;
  std::uint64_t late = 0;          // samples that came more than half a period after they were due
  bool punctual = true;            // in real time: the system permitted a real-time priority
  std::uint64_t stale = 0;         // samples without a model of the last stale_after
  std::uint64_t models = 0;        // that came
  double rate = 0;                 // Hz, held
  std::vector<double> delays;      // s, from a command to the first model that used it, one a model
  Coupling coupling;               // the rule's
  double withheld = 0, given = 0;  // J, see Passivity; given to the handle, whose own damping takes of it
  double largest_force = 0;        // N, rendered
  std::vector<double> felt;        // N/m, of the force over each way of a fifth of a millimetre against which it grew
  RestCheck rest;
};

class Session {
 public:
  explicit Session(const SessionOptions& options) : options_(options) {}

  // Makes the device of a session, which goes by this clock (s).
  using MakeDevice = std::function<std::unique_ptr<Device>(const std::function<double()>& clock)>;

  // Runs once, with the device that the options choose, or another one. Throws client::ClientError, DeviceError or
  // std::invalid_argument; the device is let go in any case.
  void run();
  void run(const MakeDevice& make);

  const SessionResults& results() const { return results_; }
  std::function<void(const SampleRecord&)> on_sample = [](const SampleRecord&) {};
  // An event of the needle that the network has delivered by `now` (s).
  std::function<void(double now, const protocol::Event&)> on_event = [](double, const protocol::Event&) {};
  // A pupil has come, or is there no longer.
  std::function<void(bool there)> on_pupil = [](bool) {};

 private:
  const protocol::NeedleInfo& choose_needle(const protocol::HelloReply& hello) const;
  void greet();
  void subscribe();
  Pose where_the_needle_rests();
  void connect_network();
  void begin(Kit& kit, const Pose& base);
  void check_server(double now);
  void loop(Device& device);
  void sample(Device& device, Kit& kit, double now);
  struct Received {
    LocalModel model;
    Wrench force;  // N, N m, world, with the needle's inertia in the tick
  };
  std::optional<Received> model_of_needle(const protocol::State& state);
  void take(Kit& kit, double now);
  void take_what_came(double now);
  void make_ticks(double now);
  void make_tick(double time);
  bool pass_on(const protocol::State& state, double now);
  void deliver_poses(double now);
  void learn_felt(const Vector3& place, const Vector3& force);
  void share(const DeviceProperties& properties);
  Kit::Answer answer(Kit& kit, const Device::Reading& reading, double now, double elapsed);
  bool continues(double now) const;

  SessionOptions options_;
  SessionResults results_;
  std::optional<client::CommandLink> commands_;
  std::optional<client::StateLink> states_;
  protocol::HelloReply server_;
  Pose base_;
  ForceModel from_force_;
  DelayLine<protocol::Pose> there_{{}};  // the simulated network
  DelayLine<std::variant<Received, protocol::Event>> back_{{}};
  std::optional<PlainRendering> plain_;  // instead of the kit
  std::optional<Teacher> teacher_;       // of a needle that is shared
  Wrench server_wrench_;                 // newest that came, on the hand at the base (N, N m, world)
  double simulated_ = 0;                 // s, the clock of a run in lockstep
  std::uint64_t ticks_ = 0;              // asked for in lockstep
  std::uint64_t newest_seq_ = 0;         // that a model used
  std::uint64_t epoch_ = 0;              // of the newest model
  double sampled_ = 0;                   // s, when the last sample was
  double heard_at_ = 0;                  // s, of the newest message
  Pose handle_;                          // at the last sample
  struct Felt {
    Vector3 place, force;
  };
  std::optional<Felt> felt_from_;
};

}  // namespace acus::haptics
