// SPDX-License-Identifier: MIT
#include "client/haptics/program/session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>
#include <variant>

#include "client/haptics/program/checked_reading.h"
#include "client/haptics/program/opened.h"
#include "client/link/priority.h"

namespace acus::haptics {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

bool publishes(const protocol::HelloReply& server, const std::string& topic) {
  return std::any_of(server.topics.begin(), server.topics.end(),
                     [&](const protocol::TopicInfo& info) { return info.name == topic; });
}

}  // namespace

const protocol::NeedleInfo& Session::choose_needle(const protocol::HelloReply& hello) const {
  if (hello.needles.empty()) throw client::ClientError("the server's scene has no needle");
  if (options_.needle.empty()) return hello.needles.front();
  for (const protocol::NeedleInfo& needle : hello.needles)
    if (needle.name == options_.needle) return needle;
  throw client::ClientError("the server's scene has no needle '" + options_.needle + "'");
}

void Session::greet() {
  commands_.emplace(options_.commands, options_.keys);
  states_.emplace(options_.states, client::StateLink::kCapacity, options_.keys);
  server_ = commands_->hello(options_.timeout);
  const protocol::NeedleInfo& needle = choose_needle(server_);
  base_ = pose_of(needle.base_position, needle.base_orientation);
  results_.scene = server_.scene;
  results_.needle = needle.name;
  results_.lockstep = server_.lockstep;
  results_.with_kit = options_.with_kit;
  results_.topic = publishes(server_, protocol::Haptics::kType) ? protocol::Haptics::kType : protocol::Force::kType;
  commands_->acquire({needle.name}, options_.timeout);
  subscribe();
  if (server_.lockstep) {
    if (commands_->hash(options_.timeout).tick == 0) return;  // the needle is where it was loaded
    commands_->step(1, options_.timeout);                     // a state of where another session left it
  }
  base_ = where_the_needle_rests();
}

// A subscription takes a moment to arrive. Statistics that come tell that the one before theirs has arrived: in
// lockstep no state may be missed.
void Session::subscribe() {
  states_->subscribe(results_.topic);
  states_->subscribe(protocol::Event::kType);
  states_->subscribe("stats");
  const auto deadline = Clock::now() + options_.timeout;
  while (Clock::now() < deadline) {
    const auto state = states_->receive(client::Timeout(10));
    if (!state || !std::holds_alternative<protocol::Stats>(*state)) continue;
    if (server_.lockstep) states_->unsubscribe("stats");
    return;
  }
  throw client::Vanished("the server at " + options_.states + " published no statistics in time");
}

// The needle may have been moved before.
Pose Session::where_the_needle_rests() {
  const auto deadline = Clock::now() + options_.timeout;
  while (Clock::now() < deadline) {
    const auto state = states_->receive(client::Timeout(10));
    if (!state) continue;
    if (const auto received = model_of_needle(*state)) return received->model.base;
  }
  throw client::Vanished("the server at " + options_.states + " published no state in time");
}

bool Session::continues(double now) const {
  const bool interrupted = options_.interrupt && *options_.interrupt;
  return !interrupted && (options_.duration == 0 || now < options_.duration);
}

// What a state says of this needle, if it does.
std::optional<Session::Received> Session::model_of_needle(const protocol::State& state) {
  const auto* haptics = std::get_if<protocol::Haptics>(&state);
  if (haptics && haptics->needle == results_.needle)
    return Received{model_of(*haptics), {{haptics->force}, {haptics->torque}}};
  const auto* force = std::get_if<protocol::Force>(&state);
  if (!force || force->needle != results_.needle) return std::nullopt;
  const LocalModel model = from_force_.of(*force);
  return Received{model, model.felt};
}

// What the network delivers by now.
void Session::take(Kit& kit, double now) {
  while (const auto delivered = back_.receive(now)) {
    if (const auto* event = std::get_if<protocol::Event>(&*delivered)) {
      if (is_felt(*event)) kit.begin_transient();
      on_event(now, *event);
      continue;
    }
    const auto* received = std::get_if<Received>(&*delivered);
    const LocalModel& model = received->model;
    ++results_.models;
    if (model.seq > newest_seq_ && model.echo > 0) {
      newest_seq_ = model.seq;
      results_.delays.push_back(now - model.echo);  // how long a command took to be felt
    }
    if (results_.models > 1 && model.epoch != epoch_) begin(kit, model.base);  // `reset`, `restore` or `load`
    epoch_ = model.epoch;
    server_wrench_ = model.felt;
    kit.take(model);
    if (plain_) plain_->take(received->force);
  }
}

// A state on its way over the network; whether it is one of this needle's force.
bool Session::pass_on(const protocol::State& state, double now) {
  if (const auto* event = std::get_if<protocol::Event>(&state); event && event->needle == results_.needle)
    back_.send(now, *event);
  const auto received = model_of_needle(state);
  if (received) back_.send(now, *received);
  return received.has_value();
}

void Session::take_what_came(double now) {
  while (const auto state = states_->receive(client::Timeout(0))) {
    heard_at_ = now;
    pass_on(*state, now);
  }
}

// In lockstep: the ticks until now, each with the poses that have come by its time.
void Session::make_ticks(double now) {
  const auto due = static_cast<std::uint64_t>(std::floor(now * server_.rate + 1e-6));
  while (ticks_ < due) make_tick(static_cast<double>(++ticks_) / server_.rate);
}

void Session::make_tick(double time) {
  deliver_poses(time);
  commands_->step(1, options_.timeout);
  while (const auto state = states_->receive(options_.timeout))
    if (pass_on(*state, time)) return;
  throw client::Vanished("the server at " + options_.states + " published no state in time");
}

// A server that does not read for a while misses poses; what is felt ends by itself then.
void Session::deliver_poses(double now) {
  while (const auto due = there_.receive(now)) [[maybe_unused]] const bool taken = commands_->send(*due);
}

void Session::learn_felt(const Vector3& place, const Vector3& force) {
  constexpr double kWay = 0.2e-3;  // m
  if (!felt_from_) felt_from_ = Felt{place, force};
  const Vector3 way = place - felt_from_->place;
  const double length = norm(way);
  if (length < kWay) return;
  const double stiffness = -dot(force - felt_from_->force, way) / (length * length);
  if (stiffness > 0) results_.felt.push_back(stiffness);
  felt_from_ = Felt{place, force};
}

void Session::sample(Device& device, Kit& kit, double now) {
  take(kit, now);
  const Device::Reading reading = checked(device.read());
  handle_ = reading.pose;
  const Kit::Answer answer = this->answer(kit, reading, now, now - sampled_);
  sampled_ = now;
  device.write(answer.on_hand);
  there_.send(now, message_of(results_.needle, answer, now));
  deliver_poses(now);
  ++results_.samples;
  if (now > 0) results_.rate = static_cast<double>(results_.samples) / now;
  if (kit.stale()) ++results_.stale;
  results_.largest_force = std::max(results_.largest_force, norm(answer.on_hand.force));
  const Passivity& passivity = teacher_ ? teacher_->hand().passivity() : kit.passivity();
  results_.withheld = passivity.withheld();
  results_.given = plain_ ? plain_->given() : passivity.given();
  learn_felt(reading.pose.position, answer.on_hand.force);
  if (!kit.stale())
    results_.rest.add(now, reading.pose.position, norm((teacher_ ? teacher_->felt() : answer.on_hand).force),
                      norm(kit.at_device(server_wrench_).force));
  on_sample({now, reading.pose, answer.base, answer.wanted, answer.on_hand, kit.at_device(server_wrench_),
             passivity.account(), passivity.withheld()});
}

// From now on the handle's place is this place of the base.
void Session::begin(Kit& kit, const Pose& base) {
  kit.begin(handle_, base);
  if (plain_) plain_->begin(handle_, base);
  if (teacher_) teacher_->begin(handle_);
}

void Session::share(const DeviceProperties& properties) {
  if (options_.sharing.endpoint.empty()) return;
  teacher_.emplace(options_.sharing, properties, options_.kit.workspace.world_from_device, server_.lockstep);
  teacher_->on_pupil = on_pupil;
  results_.shared = true;
  if (server_.lockstep) teacher_->wait_for_pupil(options_.timeout, options_.interrupt);
}

Kit::Answer Session::answer(Kit& kit, const Device::Reading& reading, double now, double elapsed) {
  if (plain_) return plain_->step(reading.pose);
  return teacher_ ? teacher_->step(kit, reading, now, elapsed) : kit.step({reading.pose, reading.clutch, elapsed});
}

// In real time: whether a server is still there, which publishes `stats` every second, also while it is paused, and
// whether the needle is still this session's; one that was started anew, or has loaded another scene, tells that it is
// not.
void Session::check_server(double now) {
  while (const auto rejection = commands_->next_rejection())
    if (rejection->code == protocol::ErrorCode::not_holder || rejection->code == protocol::ErrorCode::unknown_needle)
      throw client::Refused(*rejection);
  constexpr double kLeastSilence = 2;  // s
  const double silence = std::max(kLeastSilence, std::chrono::duration<double>(options_.timeout).count());
  if (now - heard_at_ > silence)
    throw client::Vanished("the server at " + options_.states + " has published nothing for " +
                           std::to_string(static_cast<int>(std::ceil(silence))) + " s");
}

void Session::connect_network() {
  there_ = DelayLine<protocol::Pose>(way_there(options_.network));
  back_ = DelayLine<std::variant<Received, protocol::Event>>(way_back(options_.network));
}

void Session::loop(Device& device) {
  const Opened opened(device);
  const DeviceProperties properties = device.open();
  KitOptions options = options_.kit;
  options.workspace.world_from_device = normalized(base_.orientation * options.workspace.world_from_device);
  Kit kit(properties, options);
  if (!options_.with_kit) plain_.emplace(properties, options.workspace);
  share(properties);
  results_.coupling = kit.coupling();
  handle_ = checked(device.read()).pose;
  begin(kit, base_);
  connect_network();
  const auto started = Clock::now();
  const std::chrono::duration<double> period(1 / properties.rate);
  auto due = started;
  for (std::uint64_t i = 0; continues(results_.duration); ++i) {
    if (server_.lockstep) {
      results_.duration = simulated_ = static_cast<double>(i) / properties.rate;
      make_ticks(simulated_);
    } else {
      std::this_thread::sleep_until(due);
      const auto now = Clock::now();
      if (now - due > period / 2) ++results_.late;
      // A deadline that was missed is skipped.
      while (due <= now) due += std::chrono::duration_cast<Clock::duration>(period);
      results_.duration = seconds_since(started);
      take_what_came(results_.duration);
      check_server(results_.duration);
    }
    sample(device, kit, results_.duration);
  }
}

void Session::run() {
  run([this](const std::function<double()>& clock) {
    DeviceChoice choice = options_.device;
    choice.clock = clock;
    return make_device(choice);
  });
}

void Session::run(const MakeDevice& make) {
  const bool permitted = client::raise_priority();  // before threads start, that pass messages on
  greet();
  results_.punctual = permitted || server_.lockstep;
  if (server_.lockstep) client::lower_priority();
  const auto begin = Clock::now();
  const bool lockstep = server_.lockstep;
  const std::unique_ptr<Device> device =
      make([this, begin, lockstep] { return lockstep ? simulated_ : seconds_since(begin); });
  loop(*device);
}

}  // namespace acus::haptics
