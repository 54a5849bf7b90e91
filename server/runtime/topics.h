// SPDX-License-Identifier: GPL-3.0-or-later
// The topics of the states socket and who listens to them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace acus {

enum class Topic : std::uint8_t { force, needle, tissue, event, stats, haptics };
inline constexpr int kTopicCount = 6;
inline constexpr std::array<const char*, kTopicCount> kTopicNames{"force", "needle", "tissue",
                                                                  "event", "stats",  "haptics"};

// A set of topics, one bit each, so that a thread can read it in one go.
using TopicSet = std::uint32_t;
constexpr TopicSet bit(Topic topic) { return TopicSet{1} << static_cast<int>(topic); }

// Which topics somebody listens to, from the notices of an XPUB socket: a byte 1 (subscribe) or 0 (cancel), then a
// prefix that selects every topic beginning with it. XPUB tells when a prefix gets its first subscriber and when it
// loses its last one, a disconnected one included. But it also passes on the cancel of a peer that never subscribed,
// while others still listen, and the two cannot be told apart.
//
// A cancel is therefore only a doubt, and XPUB is asked: a SUB socket of the server subscribes to a mark and to every
// doubted prefix, and cancels these and the mark. XPUB takes all of it in one go, so what it tells between the mark's
// two notices comes from that socket alone: it ends a prefix that nobody else listens to, and says nothing otherwise.
class Subscriptions {
 public:
  // The mark begins no topic, and no client can guess it.
  explicit Subscriptions(std::string mark) : mark_(std::move(mark)) {}

  const std::string& mark() const { return mark_; }

  // Takes in one notice; anything else that a client may send is ignored.
  void apply(std::string_view notice) {
    if (notice.empty() || (notice[0] != 0 && notice[0] != 1)) return;
    const bool subscribed = notice[0] == 1;
    const std::string_view prefix = notice.substr(1);
    if (prefix == mark_) {
      question_ = subscribed ? Question::being_answered : Question::none;
    } else if (!selects_a_topic(prefix)) {
      return;
    } else if (subscribed) {
      prefixes_.emplace(prefix);
    } else if (question_ == Question::being_answered) {
      prefixes_.erase(std::string(prefix));
    } else if (prefixes_.contains(prefix)) {
      doubted_.emplace(prefix);
    }
  }

  // The prefixes to ask about now; one question at a time, so that the notices of two never mix.
  std::set<std::string, std::less<>> begin_question() {
    if (question_ != Question::none || doubted_.empty()) return {};
    question_ = Question::asked;
    return std::exchange(doubted_, {});
  }

  TopicSet wanted() const {
    TopicSet set = 0;
    for (int i = 0; i < kTopicCount; ++i) {
      for (const std::string& prefix : prefixes_) {
        if (std::string_view(kTopicNames[i]).starts_with(prefix)) set |= bit(static_cast<Topic>(i));
      }
    }
    return set;
  }

 private:
  enum class Question { none, asked, being_answered };

  static bool selects_a_topic(std::string_view prefix) {
    return std::any_of(kTopicNames.begin(), kTopicNames.end(),
                       [prefix](std::string_view name) { return name.starts_with(prefix); });
  }

  std::string mark_;
  std::set<std::string, std::less<>> prefixes_;  // with a subscriber; no more than the topics have
  std::set<std::string, std::less<>> doubted_;   // of these, to be asked about
  Question question_ = Question::none;
};

}  // namespace acus
