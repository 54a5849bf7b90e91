// SPDX-License-Identifier: MIT
#include "client/haptics/program/teacher.h"

#include <algorithm>

namespace acus::haptics {

Teacher::Teacher(const SharingOptions& options, const DeviceProperties& properties, const Quaternion& turned,
                 bool lockstep)
    : options_(options),
      turned_(turned),
      lockstep_(lockstep),
      sample_time_(1 / properties.rate),
      link_(options.endpoint, PartnerLink::Side::teacher),
      hand_(properties, options.hand) {
  news_.lockstep = lockstep ? 1 : 0;
  news_.rate = properties.rate;
}

Teacher::~Teacher() {
  news_.ends = 1;
  link_.send(news_);
}

void Teacher::wait_for_pupil(client::Timeout timeout, const std::atomic<bool>* interrupt) {
  patience_ = timeout;
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (std::chrono::steady_clock::now() < end) {
    if (interrupt && *interrupt) return;
    if (link_.receive<PupilNews>(client::Timeout(100))) return;
  }
  throw client::Vanished("nobody has joined at " + options_.endpoint + " in time; start acus-haptic --join there");
}

void Teacher::begin(const Pose& handle) {
  ++news_.origin;
  start_ = before_ = handle;
  pupil_.reset();
}

// The newest of the pupil; in lockstep its answer to the last sample.
void Teacher::hear(double now) {
  const bool asked = lockstep_ && news_.sample > 0;
  while (const auto heard = link_.receive<PupilNews>(asked ? patience_ : client::Timeout(0))) {
    if (heard->ends) return lose_pupil();
    if (heard->origin == news_.origin) {
      pupil_ = heard;
      heard_ = now;
    }
    if (asked && heard->sample >= news_.sample) return;
  }
  if (asked) lose_pupil();
}

// Its way stays what it was while its share goes to nothing.
void Teacher::lose_pupil() {
  heard_ = -kStale - 1;
  lockstep_ = false;  // nobody answers any more
}

Kit::Answer Teacher::step(Kit& kit, const Device::Reading& reading, double now, double elapsed) {
  hear(now);
  const bool joint = has_pupil(now);
  if (joint != joint_) on_pupil(joint);
  joint_ = joint;
  const double wish = joint ? (options_.share ? options_.share->load() : 0.5) : 1;
  const double change = kShareChange * sample_time_;
  share_ += std::clamp(wish - share_, -change, change);
  const Quaternion turned_back = turned_.conjugate();
  const Vector6 own = turned(turned_, displacement(start_, reading.pose));
  const Vector6 other = pupil_ ? pupil_->way : own;
  const Pose both = displaced(start_, turned(turned_back, share_ * own + (1 - share_) * other));
  Kit::Answer answer = kit.step({both, reading.clutch, elapsed});
  const Wrench felt = wrench_of(turned(turned_, joined(answer.on_hand)));
  std::optional<Vector6> ahead;
  if (joint) ahead = other - own;
  const Wrench rendered =
      hand_.step(elapsed, turned(turned_, displacement(before_, reading.pose)), felt, answer.stored, share_, ahead);
  before_ = reading.pose;
  answer.on_hand = wrench_of(turned(turned_back, joined(rendered)));
  ++news_.sample;
  news_.time = now;
  news_.share = share_;
  news_.stored = answer.stored;
  news_.felt = felt;
  news_.way = own;
  link_.send(news_);
  return answer;
}

}  // namespace acus::haptics
