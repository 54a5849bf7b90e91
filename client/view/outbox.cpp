// SPDX-License-Identifier: MIT
#include "client/view/outbox.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "protocol/codec.h"

namespace acus::view {

namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

}  // namespace

Frame frame_of(std::string_view bytes) {
  Frame frame;
  frame.bytes = std::make_shared<const std::string>(bytes);
  try {
    std::visit(Overloaded{[&](const protocol::Force& state) {
                            frame.topic = "force";
                            frame.needle = state.needle;
                            frame.time = state.time;
                            frame.force = std::hypot(state.base_force[0], state.base_force[1], state.base_force[2]);
                          },
                          [&](const protocol::NeedleShape& state) {
                            frame.topic = "needle";
                            frame.needle = state.needle;
                          },
                          [&](const protocol::TissueShape&) { frame.topic = "tissue"; },
                          [&](const protocol::Event&) { frame.topic = "event"; },
                          [&](const protocol::Stats&) { frame.topic = "stats"; }, [](const auto&) {}},
               protocol::decode_state(bytes));
  } catch (const protocol::DecodeError&) {  // the page tells of it
  }
  return frame;
}

void Outbox::put(const Frame& frame) {
  ++count_;
  if (forces_.size() > kMostNeedles || newest_.size() > 2 * kMostNeedles) return;  // no scene has so many
  if (frame.topic == "force") {
    const auto [place, is_new] = forces_.try_emplace(frame.needle);
    Forces& forces = place->second;
    const Counted now{count_, frame};
    if (is_new) forces.since = frame.time;
    if (is_new || frame.force < forces.least.frame.force) forces.least = now;
    if (is_new || frame.force > forces.most.frame.force) forces.most = now;
    forces.last = now;
    add_step(forces, now);
  } else if (frame.topic == "needle" || frame.topic == "tissue" || frame.topic == "stats" || frame.topic == "cloud") {
    newest_[{frame.topic, frame.needle}] = frame;
  } else if (frame.topic == "event") {
    events_.push_back(frame);
    if (events_.size() <= kMostEvents) return;
    events_.pop_front();
    ++lost_;
  } else {
    others_.push_back(frame);
    other_bytes_ += frame.bytes->size();
    while (others_.size() > kMostOthers || (other_bytes_ > kMostBytes && others_.size() > 1)) {
      other_bytes_ -= others_.front().bytes->size();
      others_.pop_front();
      ++lost_;
    }
  }
}

void Outbox::add_step(Forces& forces, const Counted& now) {
  forces.since = std::min(forces.since, now.frame.time);  // a reset
  if (now.frame.time - forces.since < forces.step) return;
  forces.since = now.frame.time;
  forces.steps.push_back(now);
  if (forces.steps.size() < kMostSteps) return;
  forces.step *= 2;
  for (std::size_t i = 0; i < kMostSteps / 2; ++i) forces.steps[i] = std::move(forces.steps[2 * i + 1]);
  forces.steps.resize(kMostSteps / 2);
}

std::vector<std::shared_ptr<const std::string>> Outbox::take() {
  std::vector<std::shared_ptr<const std::string>> leaving;
  const auto leave = [&](const Frame& frame) { leaving.push_back(frame.bytes); };
  std::for_each(others_.begin(), others_.end(), leave);
  std::for_each(events_.begin(), events_.end(), leave);
  for (const auto& [needle, forces] : forces_) {
    std::map<std::uint64_t, const Frame*> kept;
    for (const Counted* each : {&forces.least, &forces.most, &forces.last}) kept[each->at] = &each->frame;
    for (const Counted& each : forces.steps) kept[each.at] = &each.frame;
    for (const auto& [at, frame] : kept) leave(*frame);
  }
  for (const auto& [key, frame] : newest_) leave(frame);
  others_.clear();
  other_bytes_ = 0;
  events_.clear();
  forces_.clear();
  newest_.clear();
  return leaving;
}

}  // namespace acus::view
