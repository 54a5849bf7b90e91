// SPDX-License-Identifier: GPL-3.0-or-later
// What a program tells on a processor that cannot run it.
#include "server/runtime/instruction_set.h"

#include <doctest/doctest.h>

#include <string>

namespace acus {
namespace {

// All features of the levels up to this one.
FeatureSet features_of_level(int level) {
  FeatureSet set = 0;
  for (unsigned i = 0; i < kFeatureCount; ++i)
    if (kProcessorFeatures[i].level <= level) set |= 1u << i;
  return set;
}

FeatureSet feature(const std::string& name) {
  for (unsigned i = 0; i < kFeatureCount; ++i)
    if (kProcessorFeatures[i].name == name) return 1u << i;
  FAIL("no feature " << name);
  return 0;
}

std::string message(FeatureSet needed, FeatureSet has, std::size_t size = 512) {
  std::string text(size, '?');
  explain_missing_features("acus-server", needed, has, text.data(), text.size());
  return text.c_str();
}

TEST_CASE("a processor that has all the program was built for gets no message") {
  for (int level = 1; level <= 4; ++level) {
    CHECK(message(features_of_level(level), features_of_level(level)).empty());
    CHECK(message(features_of_level(level), features_of_level(4)).empty());
    CHECK(processor_level(features_of_level(level)) == level);
  }
}

TEST_CASE("the message names what is missing and what to build instead") {
  CHECK(message(features_of_level(3), features_of_level(3) & ~feature("AVX2") & ~feature("FMA")) ==
        "acus-server: this processor lacks AVX2, FMA, for which the program was built; build it with "
        "-DACUS_ARCH=x86-64-v2\n");
  CHECK(message(features_of_level(4), features_of_level(3)) ==
        "acus-server: this processor lacks AVX512F, AVX512BW, AVX512CD, AVX512DQ, AVX512VL, for which the program was "
        "built; build it with -DACUS_ARCH=x86-64-v3\n");
  CHECK(
      message(feature("POPCNT"), 0) ==
      "acus-server: this processor lacks POPCNT, for which the program was built; build it with -DACUS_ARCH=x86-64\n");
}

TEST_CASE("a level with a gap is not reached, whatever else the processor has") {
  CHECK(processor_level(features_of_level(4) & ~feature("SSE4.2")) == 1);
  CHECK(processor_level(features_of_level(4) & ~feature("MOVBE")) == 2);
  CHECK(processor_level(0) == 1);
}

TEST_CASE("a message that does not fit is cut") {
  CHECK(message(features_of_level(4), 0, 20) == "acus-server: this p");
  CHECK(message(features_of_level(4), 0).ends_with("x86-64\n"));  // the longest there is
}

TEST_CASE("this processor has what the tests were built for") { CHECK((kBuiltFor & ~processor_features()) == 0); }

}  // namespace
}  // namespace acus
