// SPDX-License-Identifier: MIT
#include "client/haptics/kit.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "client/haptics/limits.h"

namespace acus::haptics {

namespace {

constexpr double kSettling = 2;  // ticks, tau
// A tissue that no message has shown to stick was too stiff to be seen between two messages: it sticks with so many
// times the coupling. Taken too soft, it would throw the needle back whenever it turns.
constexpr double kUnseen = 100;
constexpr double kSpeedTime = 2e-3;  // s, in which a speed is known: encoders have steps

void require_positive(double value, const char* field) {
  if (value > 0 && std::isfinite(value)) return;
  throw std::invalid_argument(std::string(field) + ": expected > 0, found " + std::to_string(value));
}

void require_not_negative(double value, const char* field) {
  if (value >= 0 && std::isfinite(value)) return;
  throw std::invalid_argument(std::string(field) + ": expected >= 0, found " + std::to_string(value));
}

DeviceProperties checked(const DeviceProperties& properties) {
  validate(properties);
  return properties;
}

// P K P with P = 1 - e e', e the direction of a way along `axis`: neither does such a way change any force, nor does
// any other way change the force along it.
Matrix6 without_axis(const Matrix6& stiffness, const Vector3& axis) {
  Matrix6 projector;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) projector(i, j) = (i == j ? 1 : 0) - (i < 3 && j < 3 ? axis[i] * axis[j] : 0);
  Matrix6 half, whole;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < 6; ++k) half(i, j) += projector(i, k) * stiffness(k, j);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < 6; ++k) whole(i, j) += half(i, k) * projector(k, j);
  return whole;
}

}  // namespace

void validate(const KitOptions& options) {
  require_positive(options.workspace.scale, "workspace.scale");
  require_positive(options.workspace.force_scale, "workspace.force_scale");
  require_positive(options.stale_after, "stale_after");
  require_positive(options.force_growth, "force_growth");
  require_positive(options.fast, "fast");
  require_not_negative(options.fast_force, "fast_force");
  require_positive(options.transient.length, "transient.length");
  require_not_negative(options.transient.height, "transient.height");
  require_not_negative(options.ramp, "ramp");
}

Kit::Kit(const DeviceProperties& properties, const KitOptions& options)
    : properties_(checked(properties)),
      options_(options),
      coupling_(coupling_of(properties)),
      registration_(options.workspace),
      passivity_(coupling_, samples_of_delay(properties)),
      ramp_(options.ramp),
      transient_(options.transient) {
  validate(options);
  const double least = Transient::kLeastSamples / properties.rate;
  if (options.transient.height > 0 && options.transient.length < least)
    throw std::invalid_argument("transient.length: expected at least " + std::to_string(least) + " s, " +
                                std::to_string(Transient::kLeastSamples) + " samples of the device, found " +
                                std::to_string(options.transient.length));
}

void Kit::begin(const Pose& device, const Pose& base) {
  registration_.bring_together(device, base);
  device_before_ = device;
  base_before_ = base;
  response_ = previous_ = LocalResponse();
  behind_ = {};
  newly_taken_ = false;
  age_ = 1e9;
  speed_ = 0;
  epoch_ = tick_ = 0;
  moving_.forget();
  contact_.reset();
}

void Kit::take(const LocalModel& model) {
  if (model.epoch < epoch_ || (model.epoch == epoch_ && model.tick < tick_)) return;
  if (model.epoch != epoch_) {
    moving_.forget();
    contact_.reset();
  } else if (model.tick > tick_ && tick_ > 0 && model.time > time_) {
    tick_time_ = (model.time - time_) / static_cast<double>(model.tick - tick_);
  }
  epoch_ = model.epoch;
  tick_ = model.tick;
  time_ = model.time;
  model_stale_ = model.stale;
  age_ = 0;
  // Springs at the device, seen from the needle; an axis without force still needs one to lead the proxy.
  const Workspace& workspace = registration_.workspace();
  const auto spring = [](double coupling, double scales) { return (coupling > 0 ? coupling : 2e3) / scales; };
  const double translation = spring(coupling_.translation_spring, workspace.force_scale * workspace.scale);
  const double rotation = spring(coupling_.rotation_spring, registration_.torque_scale());
  const LocalModel known = with_contact(model);
  if (!newly_taken_) previous_ = response_;
  newly_taken_ = true;
  const double sticking = sticking_ > 0 ? sticking_ : kUnseen * translation;
  response_ = LocalResponse(known, translation, rotation, sticking, moving_.value());
  // The command in use may not have been reached yet.
  const std::uint64_t oldest = seq_ < kKept ? 1 : seq_ - kKept + 1;
  for (std::uint64_t seq = std::max(model.seq, oldest); seq <= seq_; ++seq) response_.pass(sent_[seq % kKept]);
}

// Whether a needle in free air is just behind the surface that it pressed on: on its way back, or thrown off by its own
// inertia. Nothing shows that the surface has gone then.
bool Kit::left_contact(const LocalModel& model) const {
  constexpr double kAside = 1e-3, kTurned = 0.05;  // m, rad
  if (!contact_ || !model.is_free()) return false;
  const Vector3 axis = contact_->base.orientation * Vector3{{1, 0, 0}};
  const Vector6 moved = displacement(contact_->base, model.base);
  const Wrench halves = wrench_of(moved);
  const double advance = dot(axis, halves.force);
  return advance <= -contact_->backward && norm(halves.force - advance * axis) < kAside &&
         norm(halves.torque) < kTurned;
}

// The model, with the surface ahead of a needle that has left it: a message of one tick in the air must not open the
// way for a delay.
LocalModel Kit::with_contact(const LocalModel& model) {
  if (left_contact(model)) {
    LocalModel ahead = *contact_;
    ahead.in_air = model.felt;
    return ahead;
  }
  contact_.reset();
  if (model.backward_limit == Limit::contact) contact_ = model;
  return learnt(model);
}

// The model, without axial stiffness where the needle slides, and without any in free air, where all of it is inertia.
LocalModel Kit::learnt(const LocalModel& model) {
  const Vector3 axis = model.base.orientation * Vector3{{1, 0, 0}};
  const double stiffness = model.axial_stiffness();
  moving_.add(model, stiffness, dot(axis, base_before_.position - model.base.position));
  LocalModel learnt = model;
  if (model.is_free()) {
    learnt.stiffness = {};
    return learnt;
  }
  if (!moving_.slides(stiffness)) {
    sticking_ = stiffness;
    return learnt;
  }
  learnt.stiffness = without_axis(model.stiffness, axis);
  return learnt;
}

// Where the needle is sent as the newest model wants it at `proxy`.
Pose Kit::place_of(const Pose& target, const Pose& proxy, double sample_time) {
  if (clutched_) {
    behind_ = displacement(base_before_, proxy);
    return base_before_;
  }
  if (newly_taken_) behind_ = displacement(displaced(previous_(target).proxy, -1 * behind_), proxy);
  newly_taken_ = false;
  const double share = std::min(1 - std::exp(-sample_time / (kSettling * tick_time_)), 0.5);
  behind_ = (1 - share) * behind_;
  return displaced(proxy, -1 * behind_);
}

void Kit::remember(const Pose& base) { sent_[++seq_ % kKept] = base_before_ = base; }

// Whether the clutch parts device and needle; as it is let go, they are brought together where both stand.
bool Kit::parted(const Sample& sample) {
  if (clutched_ && !sample.clutch) registration_.bring_together(sample.device, base_before_);
  clutched_ = sample.clutch;
  return clutched_;
}

void Kit::observe(const Pose& device, double elapsed) {
  const Vector6 moved = displacement(device_before_, device);
  passivity_.observe(moved, elapsed * properties_.rate);
  const double share = 1 - std::exp(-elapsed / kSpeedTime);
  speed_ += share * (norm(wrench_of(moved).force) / elapsed - speed_);
  device_before_ = device;
}

// N, device frame.
Vector3 Kit::transient(double sample_time) {
  const Quaternion& world_from_device = registration_.workspace().world_from_device;
  const Vector3 ahead = world_from_device.conjugate() * (base_before_.orientation * Vector3{{1, 0, 0}});
  return transient_.step(sample_time) * ahead;
}

// J, that a transient costs on top of this wrench, if one may come.
double Kit::kept_for_transient(const Wrench& rendered) const {
  const double height = transient_.height();
  if (!(height > 0 && coupling_.translation > 0)) return 0;
  return (2 * norm(rendered.force) + height) * height / (2 * coupling_.translation);
}

Kit::Answer Kit::step(const Sample& sample) {
  const double sample_time = std::max(1 / properties_.rate, sample.elapsed);  // in this order NaN is none
  observe(sample.device, sample_time);
  const bool apart = parted(sample);
  age_ += sample_time;
  const double factor = ramp_.step(!apart && !stale() && !model_stale_, sample_time);
  const Pose target = apart ? base_before_ : registration_.base_of(sample.device);
  const LocalResponse::Answer answer = response_(target);
  remember(place_of(target, answer.proxy, sample_time));

  Answer result;
  result.base = base_before_;
  result.seq = seq_;
  result.wanted = registration_.at_device(answer.felt);
  result.wanted.force += transient(sample_time);
  const Wrench ramped{factor * result.wanted.force, factor * result.wanted.torque};
  const double power_scale = registration_.workspace().force_scale / registration_.workspace().scale;
  const Wrench felt{factor * answer.felt.force, factor * answer.felt.torque};
  result.stored = power_scale * response_.stored(felt, moving_.softest()) + kept_for_transient(ramped);
  const double most = speed_ > options_.fast ? options_.fast_force : properties_.translation.largest_force;
  const Wrench limited = within_limits(before_, ramped, properties_, options_.force_growth / properties_.rate, most);
  result.on_hand = before_ = passivity_.control(limited, result.stored);
  return result;
}

}  // namespace acus::haptics
