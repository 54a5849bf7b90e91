// SPDX-License-Identifier: MIT
#include "client/haptics/program/pupil.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>

#include "client/haptics/program/checked_reading.h"
#include "client/haptics/program/opened.h"
#include "client/haptics/program/teacher.h"
#include "client/link/priority.h"

namespace acus::haptics {

namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

bool Pupil::continues() const {
  const bool interrupted = options_.interrupt && *options_.interrupt;
  return !interrupted && (options_.duration == 0 || now_ < options_.duration);
}

// Says that it is there until the teacher answers.
std::optional<TeacherNews> Pupil::wait_for_teacher() {
  const auto end = Clock::now() + options_.timeout;
  while (Clock::now() < end) {
    if (!continues()) return std::nullopt;
    link_.send(PupilNews{});
    if (const auto news = link_.receive<TeacherNews>(client::Timeout(200))) return news;
  }
  throw client::Vanished("no acus-haptic --share was at " + options_.endpoint + " in time");
}

void Pupil::hear(const TeacherNews& news) {
  if (!teacher_ || news.origin != teacher_->origin) first_ = true;  // ways begin where the teacher is
  teacher_ = news;
  heard_ = now_;
}

void Pupil::sample(Device& device, SharedHand& hand) {
  while (const auto news = there_.receive(now_)) hear(*news);
  const Pose handle = checked(device.read()).pose;
  if (samples_ == 0) before_ = handle;
  if (first_ && teacher_) {
    start_ = handle;
    offset_ = teacher_->way;
    first_ = false;
  }
  const double elapsed = samples_ > 0 ? now_ - sampled_ : 0;
  sampled_ = now_;
  PupilSample record{now_, handle, {}, 0, {}, 0};
  PupilNews news;
  std::optional<Vector6> ahead;
  Wrench felt;
  double stored = 0;
  if (teacher_) {
    news.origin = teacher_->origin;
    news.way = offset_ + turned(options_.turned, displacement(start_, handle));
    record.share = 1 - teacher_->share;
    if (now_ - heard_ <= Teacher::kStale) {
      ahead = record.ahead = teacher_->way - news.way;
      felt = teacher_->felt;
      stored = teacher_->stored;
    }
  }
  const Wrench rendered =
      hand.step(elapsed, turned(options_.turned, displacement(before_, handle)), felt, stored, record.share, ahead);
  before_ = handle;
  record.rendered = wrench_of(turned(options_.turned.conjugate(), joined(rendered)));
  device.write(record.rendered);
  back_.send(now_, news);
  while (const auto due = back_.receive(now_)) told_ = *due;
  ++samples_;
  record.account = hand.passivity().account();
  withheld_ = hand.passivity().withheld();
  given_ = hand.passivity().given();
  largest_force_ = std::max(largest_force_, norm(rendered.force));
  on_sample(record);
}

// The teacher waits for an answer to each of its samples.
void Pupil::loop_in_lockstep(Device& device, SharedHand& hand, TeacherNews news) {
  const double begun = news.time;
  while (!news.ends) {
    now_ = news.time - begun;
    if (!continues()) break;
    there_.send(now_, news);
    sample(device, hand);
    PupilNews answer = told_;
    answer.sample = news.sample;
    link_.send(answer);
    const auto next = link_.receive<TeacherNews>(options_.timeout);
    if (!continues()) break;
    if (!next) throw client::Vanished("the teacher at " + options_.endpoint + " has gone silent");
    news = *next;
  }
}

void Pupil::loop_in_real_time(Device& device, SharedHand& hand, double rate) {
  constexpr double kLeastSilence = 2;  // s
  const double silence = std::max(kLeastSilence, std::chrono::duration<double>(options_.timeout).count());
  const auto begun = Clock::now();
  const std::chrono::duration<double> period(1 / rate);
  double last = 0;  // s, when something came
  for (auto due = begun; continues();) {
    std::this_thread::sleep_until(due);
    const auto now = Clock::now();
    while (due <= now) due += std::chrono::duration_cast<Clock::duration>(period);
    now_ = std::chrono::duration<double>(now - begun).count();
    while (const auto news = link_.receive<TeacherNews>(client::Timeout(0))) {
      if (news->ends) return;
      there_.send(now_, *news);
      last = now_;
    }
    if (now_ - last > silence) throw client::Vanished("the teacher at " + options_.endpoint + " has gone silent");
    sample(device, hand);
    link_.send(told_);
  }
}

void Pupil::run() {
  client::raise_priority();
  const std::optional<TeacherNews> news = wait_for_teacher();
  if (!news) return;  // interrupted
  const bool lockstep = news->lockstep != 0;
  if (lockstep) client::lower_priority();
  const auto begun = Clock::now();
  DeviceChoice choice = options_.device;
  if (lockstep) choice.rate = news->rate;  // it is asked for a sample at each of the teacher's
  choice.clock = [this, lockstep, begun] {
    return lockstep ? now_ : std::chrono::duration<double>(Clock::now() - begun).count();
  };
  const std::unique_ptr<Device> device = make_device(choice);
  const Opened opened(*device);
  const DeviceProperties properties = device->open();
  there_ = DelayLine<TeacherNews>(way_there(options_.network));
  back_ = DelayLine<PupilNews>(way_back(options_.network));
  SharedHand hand(properties, options_.hand);
  if (lockstep)
    loop_in_lockstep(*device, hand, *news);
  else
    loop_in_real_time(*device, hand, properties.rate);
  PupilNews farewell;
  farewell.ends = 1;
  link_.send(farewell);
}

}  // namespace acus::haptics
