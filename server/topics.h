// SPDX-License-Identifier: GPL-3.0-or-later
// The topics of the states socket and who listens to them.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace acus {

enum class Topic : std::uint8_t { force, needle, tissue, event, stats };
inline constexpr int kTopicCount = 5;
inline constexpr std::array<const char*, kTopicCount> kTopicNames{"force", "needle", "tissue", "event", "stats"};

// A set of topics, one bit each, so that a thread can read it in one go.
using TopicSet = std::uint32_t;
constexpr TopicSet bit(Topic topic) { return TopicSet{1} << static_cast<int>(topic); }

// Which topics somebody listens to, from the notices of an XPUB socket: a byte 1 (subscribe) or 0 (unsubscribe), then
// a prefix that selects every topic beginning with it. XPUB sends each prefix once when its first subscriber comes and
// once when its last one goes, disconnected ones included, so that counting prefixes per topic is enough.
class Subscriptions {
 public:
  // Takes in one notice; anything else that a client may send is ignored.
  void apply(std::string_view notice) {
    if (notice.empty() || (notice[0] != 0 && notice[0] != 1)) return;
    for (int i = 0; i < kTopicCount; ++i) {
      if (!std::string_view(kTopicNames[i]).starts_with(notice.substr(1))) continue;
      if (notice[0] == 1) {
        ++prefixes_[i];
      } else if (prefixes_[i] > 0) {
        --prefixes_[i];
      }
    }
  }

  TopicSet wanted() const {
    TopicSet set = 0;
    for (int i = 0; i < kTopicCount; ++i) set |= prefixes_[i] > 0 ? bit(static_cast<Topic>(i)) : 0;
    return set;
  }

 private:
  std::array<int, kTopicCount> prefixes_{};
};

}  // namespace acus
