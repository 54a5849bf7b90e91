// SPDX-License-Identifier: GPL-3.0-or-later
// The local model of a message of the topic `haptics`.
#include "client/haptics/message.h"

#include <doctest/doctest.h>

using namespace acus;
using namespace acus::haptics;

namespace {

// A needle along the world's z, held by 500 N/m and pushed back with `resistance` (N).
protocol::Haptics pushed(double resistance, double forward_yield, double backward_yield) {
  protocol::Haptics message;
  message.tick = 7;
  message.seq = 3;
  message.position = {1, 2, 3};
  const double half = 0.70710678118654752;
  message.orientation = {half, 0, -half, 0};  // x to z
  message.force = {0, 0, -resistance - 0.2};
  message.lasting_force = {0, 0, -resistance};
  message.stiffness.assign(36, 0);
  message.stiffness[14] = -500;
  message.forward_yield = forward_yield;
  message.backward_yield = backward_yield;
  return message;
}

}  // namespace

TEST_CASE("a message's model is felt without the needle's inertia, as stiff as the tick along its axis") {
  const LocalModel model = model_of(pushed(0.3, 0.8, 0.5));
  CHECK(model.tick == 7);
  CHECK(model.seq == 3);
  CHECK(model.base.position[2] == 3);
  CHECK(model.felt.force[2] == -0.3);
  CHECK(model.axial_stiffness() == doctest::Approx(500));
}

TEST_CASE("a needle inside slides where all its points have yielded") {
  const LocalModel model = model_of(pushed(0.3, 0.8, 0.5));
  CHECK(model.forward == doctest::Approx(1e-3));
  CHECK(model.backward == doctest::Approx(1.6e-3));
  CHECK(model.forward_limit == Limit::slip);
  CHECK(model.backward_limit == Limit::slip);
  protocol::Haptics cutting = pushed(0.3, 0.8, 0.5);
  cutting.forward_limit = protocol::ModelLimit::cutting;
  CHECK(model_of(cutting).forward_limit == Limit::cutting);
  CHECK(model_of(pushed(0.9, 0.8, 0.5)).forward == 0);
}

TEST_CASE("a needle that touches lets go where nothing is felt, and one in the air has no limits") {
  const LocalModel touching = model_of(pushed(0.3, 1e6, 0));
  CHECK(touching.forward == 1);
  CHECK(touching.forward_limit == Limit::puncture);
  CHECK(touching.backward == doctest::Approx(0.6e-3));
  CHECK(touching.backward_limit == Limit::contact);
  CHECK(model_of(pushed(0, 0, 0)).is_free());
}

TEST_CASE("a message without its stiffness is a model without stiffness") {
  protocol::Haptics message = pushed(0.3, 0.8, 0.5);
  message.stiffness.clear();
  CHECK(model_of(message).axial_stiffness() == 0);
}
