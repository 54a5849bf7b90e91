// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/topics.h"

#include <doctest/doctest.h>

#include <string>

namespace acus {
namespace {

constexpr TopicSet kAll = (1u << kTopicCount) - 1;

void subscribe(Subscriptions& subscriptions, const std::string& prefix) { subscriptions.apply('\1' + prefix); }
void unsubscribe(Subscriptions& subscriptions, const std::string& prefix) {
  subscriptions.apply(std::string(1, '\0') + prefix);
}

}  // namespace

TEST_CASE("nobody listens at first") { CHECK(Subscriptions().wanted() == 0); }

TEST_CASE("a topic is wanted from its first subscription to its last") {
  Subscriptions subscriptions;
  subscribe(subscriptions, "force");
  CHECK(subscriptions.wanted() == bit(Topic::force));
  subscribe(subscriptions, "stats");
  CHECK(subscriptions.wanted() == (bit(Topic::force) | bit(Topic::stats)));
  unsubscribe(subscriptions, "force");
  CHECK(subscriptions.wanted() == bit(Topic::stats));
}

TEST_CASE("a prefix wants every topic that begins with it") {
  Subscriptions subscriptions;
  subscribe(subscriptions, "");
  CHECK(subscriptions.wanted() == kAll);
  subscribe(subscriptions, "fo");
  unsubscribe(subscriptions, "");
  CHECK(subscriptions.wanted() == bit(Topic::force));
  subscribe(subscriptions, "force/left");
  unsubscribe(subscriptions, "fo");
  CHECK(subscriptions.wanted() == 0);
}

TEST_CASE("what is no notice is ignored") {
  Subscriptions subscriptions;
  subscriptions.apply("");
  subscriptions.apply("force");
  subscriptions.apply("\2force");
  unsubscribe(subscriptions, "force");
  CHECK(subscriptions.wanted() == 0);
  subscribe(subscriptions, "force");
  CHECK(subscriptions.wanted() == bit(Topic::force));
}

}  // namespace acus
