// SPDX-License-Identifier: GPL-3.0-or-later
// What the server tells and publishes, as messages of the protocol, made of a recording that is run again.
#pragma once

#include "protocol/messages.h"
#include "server/engine/recording/rerun.h"
#include "server/engine/tick/drawn_tissue.h"

namespace acus {

// Of the scene and the epoch that the rerun is in.
protocol::HelloReply hello_of(const Rerun& rerun);
protocol::DescribeReply describe_of(const Rerun& rerun);

// Of a needle after a tick. A recording does not tell how commands came in: that is 0. Nor does it tell what a device
// was to feel when they did not: `haptic_force` and `haptic_torque` are those at the base.
protocol::Force force_of(const Rerun& rerun, int needle);

// Shapes after a tick, in memory that is used again.
class RecordedShapes {
 public:
  // Of the scene that the rerun is in.
  explicit RecordedShapes(const Rerun& rerun);

  const protocol::NeedleShape& needle(const Rerun& rerun, int needle);
  const protocol::TissueShape& tissue(const Rerun& rerun);

 private:
  protocol::NeedleShape needle_;
  protocol::TissueShape tissue_;
  DrawnTissue drawn_;  // scratch
};

int needle_count(const Rerun& rerun);

}  // namespace acus
