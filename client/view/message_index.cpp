// SPDX-License-Identifier: MIT
#include "client/view/message_index.h"

#include <algorithm>
#include <map>
#include <msgpack.hpp>

#include "protocol/codec.h"

namespace acus::view {

namespace {

constexpr std::size_t kAtATime = 4 << 20;  // bytes

// Bytes of the first message of a sequence; 0: it is not whole. Throws msgpack::parse_error.
std::size_t size_of_first(std::string_view bytes) {
  std::size_t size = 0;
  msgpack::null_visitor nothing;
  try {
    return msgpack::parse(bytes.data(), bytes.size(), size, nothing) ? size : 0;
  } catch (const msgpack::insufficient_bytes&) {
    return 0;
  }
}

}  // namespace

bool MessageIndex::read_on() {
  if (!file_.is_open()) file_.open(path_, std::ios::binary);
  if (!file_.is_open()) return false;
  const std::size_t before = unread_.size();
  const std::uint64_t from = offset_ + before;
  file_.clear();
  file_.seekg(0, std::ios::end);
  const auto size_now = static_cast<std::uint64_t>(file_.tellg());
  if (size_now <= from) return false;  // room for what has come, and no more: a growing file is asked often
  const std::size_t count = std::min<std::uint64_t>(size_now - from, kAtATime);
  unread_.resize(before + count);
  file_.seekg(static_cast<std::streamoff>(from));
  file_.read(unread_.data() + before, static_cast<std::streamsize>(count));
  unread_.resize(before + static_cast<std::size_t>(file_.gcount()));
  if (unread_.size() == before) return false;
  std::string_view rest = unread_;
  for (std::size_t size; (size = size_of_first(rest)) > 0; rest.remove_prefix(size), offset_ += size)
    add(rest.substr(0, size), offset_);
  unread_ = std::string(rest);
  return true;
}

void MessageIndex::add(std::string_view message, std::uint64_t offset) {
  if (describe_.empty()) {
    (hello_.empty() ? hello_ : describe_) = message;
    return;
  }
  const Frame frame = frame_of(message);
  const bool shape = frame.topic == "needle" || frame.topic == "tissue";
  if (shapes_ && !shape) begins_.push_back(entries_.size());
  shapes_ = shape;
  entries_.push_back(
      {offset, static_cast<std::uint32_t>(message.size()), frame.topic == "event", frame.topic == "force"});
}

void MessageIndex::close() {
  if (!entries_.empty() && (begins_.empty() || begins_.back() < entries_.size())) begins_.push_back(entries_.size());
}

std::string MessageIndex::load(const Entry& entry) {
  std::string bytes(entry.size, '\0');
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(entry.offset));
  file_.read(bytes.data(), entry.size);
  return bytes;
}

void MessageIndex::visit(std::size_t frame, const std::function<void(const Frame&)>& take) {
  for (std::size_t i = begins_[frame]; i < begins_[frame + 1]; ++i) take(frame_of(load(entries_[i])));
}

void MessageIndex::visit_history(std::size_t from, std::size_t frame, std::size_t stride,
                                 const std::function<void(const Frame&)>& take) {
  for (std::size_t f = 0; f < frame; ++f) {
    std::map<std::string, Frame> last;
    const bool forces = f >= from && (f - from) % stride == 0;
    for (std::size_t i = begins_[f]; i < begins_[f + 1]; ++i) {
      const Entry& entry = entries_[i];
      if (entry.event) take(frame_of(load(entry)));
      if (!entry.force || !forces) continue;
      Frame force = frame_of(load(entry));
      last[force.needle] = std::move(force);
    }
    for (const auto& [needle, force] : last) take(force);
  }
}

}  // namespace acus::view
