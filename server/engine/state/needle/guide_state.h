// SPDX-License-Identifier: GPL-3.0-or-later
// What a guide remembers from tick to tick; tick/contact/guides.h says what it does.
#pragma once

#include "server/engine/state/needle/base_state.h"
#include "server/engine/state/needle/contact_state.h"

namespace acus {

struct GuideState {
  BaseState motion;  // of the hole
  double s = 0;      // m, of Q along the needle
  ContactState contact{};

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("motion", self.motion);
    visit("s", self.s);
    visit("contact", self.contact);
  }
};

}  // namespace acus
