// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/export/recorded_states.h"

#include "server/runtime/convert.h"
#include "server/runtime/loaded_scene.h"

namespace acus {

namespace {

const std::string& needle_name(const Rerun& rerun, int needle) {
  return rerun.simulation().scene().needles[static_cast<std::size_t>(needle)].name;
}

}  // namespace

int needle_count(const Rerun& rerun) { return static_cast<int>(rerun.simulation().scene().needles.size()); }

protocol::HelloReply hello_of(const Rerun& rerun) {
  protocol::HelloReply hello = hello_of(rerun.simulation());
  hello.epoch = rerun.epoch();
  return hello;
}

protocol::DescribeReply describe_of(const Rerun& rerun) {
  protocol::DescribeReply describe = describe_of(rerun.simulation());
  describe.epoch = rerun.epoch();
  return describe;
}

protocol::Force force_of(const Rerun& rerun, int needle) {
  const TickReport& report = rerun.simulation().report();
  protocol::Force force;
  force.epoch = rerun.epoch();
  force.tick = report.tick;
  force.time = report.time;
  force.needle = needle_name(rerun, needle);
  put(report.needles[static_cast<std::size_t>(needle)], force);
  force.haptic_force = force.base_force;
  force.haptic_torque = force.base_torque;
  force.solver = report.solver;
  force.flags = report.flags;
  return force;
}

RecordedShapes::RecordedShapes(const Rerun& rerun) : drawn_(rerun.simulation().model()) {
  tissue_.positions.resize(static_cast<std::size_t>(rerun.simulation().mesh().nodes.size()));
}

const protocol::NeedleShape& RecordedShapes::needle(const Rerun& rerun, int needle) {
  needle_.epoch = rerun.epoch();
  needle_.needle = needle_name(rerun, needle);
  put(rerun.simulation(), needle, needle_);
  return needle_;
}

const protocol::TissueShape& RecordedShapes::tissue(const Rerun& rerun) {
  tissue_.epoch = rerun.epoch();
  put(rerun.simulation(), drawn_, tissue_);
  return tissue_;
}

}  // namespace acus
