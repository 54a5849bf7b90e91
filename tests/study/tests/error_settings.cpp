// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/error_settings.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>
#include <string>

#include "tests/support/places.h"

namespace acus {
namespace {

TEST_CASE("every run is compared with itself or one that comes before it, of the same kind") {
  for (const bool quick : {true, false})
    for (const StudiedScene& studied : studied_scenes(quick)) {
      const auto settings = settings_of(studied);
      for (std::size_t i = 0; i < settings.size(); ++i) {
        CAPTURE(settings[i].knob);
        CAPTURE(settings[i].value);
        CHECK_FALSE(settings[i].comparisons.empty());
        for (const Comparison& comparison : settings[i].comparisons) {
          REQUIRE(comparison.with <= i);
          const Setting& reference = settings[comparison.with];
          if (comparison.kind == std::string("solver")) CHECK(reference.h == settings[i].h);
          if (comparison.kind == std::string("total")) CHECK(reference.h == studied.steps.front());
          if (comparison.kind == std::string("discretisation")) CHECK(reference.knob == settings[i].knob);
        }
      }
    }
}

TEST_CASE("every knob is turned, in the short form, too") {
  for (const bool quick : {true, false}) {
    std::set<std::string> knobs;
    for (const StudiedScene& studied : studied_scenes(quick))
      for (const Setting& setting : settings_of(studied)) knobs.insert(setting.knob);
    CHECK(knobs == std::set<std::string>{"time step", "rung", "laws", "gauss_seidel tolerance", "gauss_seidel steps",
                                         "beams", "spacing", "cells"});
  }
}

TEST_CASE("the settings leave scenes that can be used") {
  for (const StudiedScene& studied : studied_scenes(false))
    for (const Setting& setting : settings_of(studied)) {
      Scene scene = read_scene(source_path("scenes/") + studied.name + ".yaml");
      scene.rate = 1 / setting.h;
      setting.change(scene);
      CAPTURE(setting.value);
      CHECK_NOTHROW(validate(scene));
    }
}

}  // namespace
}  // namespace acus
