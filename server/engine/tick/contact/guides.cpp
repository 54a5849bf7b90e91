// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/contact/guides.h"

#include <algorithm>
#include <cassert>

namespace acus {

void begin_guide(const BaseLimits& limits, double h, const GuideState& state, const std::optional<Command>& newest,
                 std::uint64_t tick, GuideScratch& scratch) {
  assert(h > 0);
  scratch.next = state;
  scratch.next.motion = follow(limits, h, state.motion, newest, tick);
  const Pose pose = scratch.next.motion.spun_pose();
  scratch.before = state.motion.pose.position;
  scratch.center = pose.position;
  scratch.axis = pose.orientation * Vector3::UnitX();
}

void locate_guide(const NeedleView& needle, GuideScratch& scratch) {
  double& s = scratch.next.s;
  s = project_on_curve(needle, scratch.center, scratch.axis, s);
  scratch.holds = s >= 0 && s <= needle.model.length;
}

void find_guide_contacts(const Guide& parameters, int index, const NeedleView& needle, GuideScratch& scratch,
                         Contacts& contacts) {
  assert(parameters.play >= 0 && index >= 0);
  if (!scratch.holds) return;
  GuideState& next = scratch.next;
  Contact contact{.kind = ContactKind::guide,
                  .needle = index,
                  .on_needle = curve_point(needle.model, needle.shape, next.s),
                  .state = &next.contact};
  const Vector3 apart = contact.on_needle.position - scratch.center;
  if (parameters.play == 0) {
    contact.hold = Across{.tangent = scratch.axis, .apart = apart};
    contacts.put(contact);
  } else if (const Vector3 off = apart - apart.dot(scratch.axis) * scratch.axis; off.norm() > 0) {
    const Vector3 n = -off.normalized();
    contact.hold =
        Normal{.n = n, .gap = parameters.play - off.norm(), .before = std::max(0.0, next.contact.across.dot(n))};
    contacts.put(contact);
  }
  Along along{.tangent = scratch.axis};
  along.friction.law.threshold = parameters.friction * next.contact.across.norm();
  if (along.friction.law.threshold == 0) return;
  along.slip = scratch.axis.dot((contact.on_needle.position - needle.start_position(next.s)) -
                                (scratch.center - scratch.before));
  contact.hold = along;
  contacts.put(contact);
}

}  // namespace acus
