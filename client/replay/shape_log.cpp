// SPDX-License-Identifier: MIT
#include "client/replay/shape_log.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "client/link/client.h"
#include "protocol/codec.h"

namespace acus::client {
namespace {

// Ticks between two states of a topic.
std::uint64_t period_of(const protocol::HelloReply& hello, const std::string& name) {
  const auto topic = std::find_if(hello.topics.begin(), hello.topics.end(),
                                  [&](const protocol::TopicInfo& info) { return info.name == name; });
  if (topic == hello.topics.end() || !(topic->rate > 0)) {
    throw ProtocolMismatch("the server does not tell at which rate it publishes '" + name + "'");
  }
  return static_cast<std::uint64_t>(std::max(1.0, std::round(hello.rate / topic->rate)));
}

}  // namespace

bool are_messages(std::string_view beginning) {
  constexpr std::size_t kMost = 16;  // bytes, in which the type of a message stands
  return beginning.substr(0, kMost + std::strlen(protocol::HelloReply::kType)).find(protocol::HelloReply::kType) !=
         std::string_view::npos;
}

ShapeLog::ShapeLog(const std::string& path) : file_(path, are_messages) {}

void ShapeLog::begin(const protocol::HelloReply& hello, const protocol::DescribeReply& describe) {
  tissue_.period = period_of(hello, protocol::TissueShape::kType);
  const std::uint64_t needle_period = period_of(hello, protocol::NeedleShape::kType);
  for (const protocol::NeedleInfo& needle : hello.needles) needles_[needle.name].period = needle_period;
  append(hello);
  append(describe);
}

void ShapeLog::write(const protocol::NeedleShape& shape) {
  needles_[shape.needle].take(shape.tick);
  ++shapes_;
  append(shape);
}

void ShapeLog::write(const protocol::TissueShape& shape) {
  tissue_.take(shape.tick);
  ++shapes_;
  append(shape);
}

void ShapeLog::write(const protocol::Pose& guide) { append(guide); }

bool ShapeLog::complete_at(std::uint64_t tick) const {
  const auto complete = [tick](const Series& series) { return tick % series.period != 0 || series.last_tick >= tick; };
  return complete(tissue_) &&
         std::all_of(needles_.begin(), needles_.end(), [&](const auto& entry) { return complete(entry.second); });
}

std::uint64_t ShapeLog::lost() const {
  std::uint64_t lost = tissue_.lost;
  for (const auto& [name, series] : needles_) lost += series.lost;
  return lost;
}

void ShapeLog::Series::take(std::uint64_t tick) {
  if (last_tick > 0 && tick > last_tick + period) lost += (tick - last_tick) / period - 1;
  last_tick = tick;
}

template <class Message>
void ShapeLog::append(const Message& message) {
  protocol::encode(message, bytes_);
  file_.out().write(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
}

void ShapeLog::close() { file_.close(); }

}  // namespace acus::client
