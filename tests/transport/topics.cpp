// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/topics.h"

#include <doctest/doctest.h>

#include <string>

namespace acus {
namespace {

constexpr TopicSet kAll = (1u << kTopicCount) - 1;

using Prefixes = std::set<std::string, std::less<>>;

Subscriptions nobody() { return Subscriptions("?mark"); }

void subscribe(Subscriptions& subscriptions, const std::string& prefix) { subscriptions.apply('\1' + prefix); }
void cancel(Subscriptions& subscriptions, const std::string& prefix) {
  subscriptions.apply(std::string(1, '\0') + prefix);
}

// What XPUB tells when it is asked about prefixes of which these have no other subscriber.
void answer(Subscriptions& subscriptions, const Prefixes& without_subscriber) {
  subscribe(subscriptions, "?mark");
  for (const std::string& prefix : without_subscriber) {
    subscribe(subscriptions, prefix);
    cancel(subscriptions, prefix);
  }
  cancel(subscriptions, "?mark");
}

}  // namespace

TEST_CASE("nobody listens at first") { CHECK(nobody().wanted() == 0); }

TEST_CASE("a topic is wanted from its first subscription until nobody is left") {
  Subscriptions subscriptions = nobody();
  subscribe(subscriptions, "force");
  CHECK(subscriptions.wanted() == bit(Topic::force));
  subscribe(subscriptions, "stats");
  CHECK(subscriptions.wanted() == (bit(Topic::force) | bit(Topic::stats)));
  cancel(subscriptions, "force");
  CHECK(subscriptions.begin_question() == Prefixes{"force"});
  answer(subscriptions, {"force"});
  CHECK(subscriptions.wanted() == bit(Topic::stats));
}

TEST_CASE("a cancel ends nothing while somebody is left, however often it comes") {
  Subscriptions subscriptions = nobody();
  subscribe(subscriptions, "force");
  for (int i = 0; i < 3; ++i) {
    cancel(subscriptions, "force");
    cancel(subscriptions, "force");
    CHECK(subscriptions.begin_question() == Prefixes{"force"});
    CHECK(subscriptions.wanted() == bit(Topic::force));
    answer(subscriptions, {});
    CHECK(subscriptions.wanted() == bit(Topic::force));
  }
}

TEST_CASE("one question is open at a time, and cancels that come meanwhile wait for the next") {
  Subscriptions subscriptions = nobody();
  subscribe(subscriptions, "force");
  subscribe(subscriptions, "needle");
  cancel(subscriptions, "force");
  CHECK(subscriptions.begin_question() == Prefixes{"force"});
  cancel(subscriptions, "needle");
  CHECK(subscriptions.begin_question().empty());
  answer(subscriptions, {"force"});
  CHECK(subscriptions.wanted() == bit(Topic::needle));
  CHECK(subscriptions.begin_question() == Prefixes{"needle"});
  answer(subscriptions, {"needle"});
  CHECK(subscriptions.wanted() == 0);
  CHECK(subscriptions.begin_question().empty());
}

TEST_CASE("who comes around a question counts") {
  Subscriptions before = nobody(), after = nobody();
  for (Subscriptions* subscriptions : {&before, &after}) {
    subscribe(*subscriptions, "force");
    cancel(*subscriptions, "force");
    subscriptions->begin_question();
  }
  subscribe(before, "force");  // so that XPUB has nothing to tell
  answer(before, {});
  CHECK(before.wanted() == bit(Topic::force));
  answer(after, {"force"});
  subscribe(after, "force");
  CHECK(after.wanted() == bit(Topic::force));
}

TEST_CASE("a prefix wants every topic that begins with it") {
  Subscriptions subscriptions = nobody();
  subscribe(subscriptions, "");
  CHECK(subscriptions.wanted() == kAll);
  subscribe(subscriptions, "f");
  subscribe(subscriptions, "fo");
  cancel(subscriptions, "");
  cancel(subscriptions, "f");
  CHECK(subscriptions.begin_question() == Prefixes{"", "f"});
  answer(subscriptions, {"", "f"});
  CHECK(subscriptions.wanted() == bit(Topic::force));
  subscribe(subscriptions, "force/left");
  cancel(subscriptions, "fo");
  CHECK(subscriptions.begin_question() == Prefixes{"fo"});
  answer(subscriptions, {"fo"});
  CHECK(subscriptions.wanted() == 0);
}

TEST_CASE("what is no notice, or of no topic, is ignored") {
  Subscriptions subscriptions = nobody();
  subscriptions.apply("");
  subscriptions.apply("force");
  subscriptions.apply("\2force");
  cancel(subscriptions, "force");
  cancel(subscriptions, "forces");
  subscribe(subscriptions, "forces");
  CHECK(subscriptions.begin_question().empty());
  CHECK(subscriptions.wanted() == 0);
  subscribe(subscriptions, "force");
  CHECK(subscriptions.wanted() == bit(Topic::force));
}

}  // namespace acus
