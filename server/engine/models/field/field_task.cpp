// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/field/field_task.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace acus {

namespace {

constexpr double kStepShare = 1.0 / 512;  // of all work, which a step is not to be longer than if it can be cut
// Entries of a factor in half precision that forward goes through in the same time.
constexpr double kBackwardEntry = 1.4;
constexpr double kBatch = 1900;     // elastic forces of eight elements
constexpr double kTurnBatch = 700;  // what they give to the rotations of nodes
constexpr double kNormalizeNode = 20, kGatherNode = 80, kSmoothNode = 80;
constexpr double kPrepareNode = 50;
constexpr double kCarryNode = 50, kFeedNode = 60;
constexpr double kPlaceNode = 580, kDefectNode = 580, kProjectNode = 120;

// Defects, as the roots of sums of squares, that stop the field: they have grown by kGrowth so many times in a row and
// are kPart of weight and rows' forces, or are kMost of them and have grown at all.
constexpr int kGrowing = 3;
constexpr double kGrowth = 1.2, kPart = 1, kMost = 3;  // -
constexpr double kLeast = 1e-2;                        // N, that stop it
constexpr double kFading = 0.9;                        // -, a window, of forces that act no more
constexpr double kLeastShare = 1.0 / 64;               // -, of a defect that is fed in
constexpr double kComingBack = 1.02;                   // -, of that, a window

}  // namespace

FieldTask::FieldTask(const TissueSystem& system, std::shared_ptr<FieldWindow> memory)
    : free_at_(system.position.size()),
      held_(system.position.size(), -1),
      panel_rows_(system.factor.make_panel_rows()),
      elements_(system.model) {
  const TissueModel& model = system.model;
  result_.window = std::move(memory);
  result_.element_rotations = ElementRotations(model);
  result_.ahead = model.mesh->nodes;
  result_.v.setZero(3, model.nodes());
  sums_.setZero(4, system.rotation_grid.points);
  for (std::size_t f = 0; f < free_at_.size(); ++f) free_at_[system.position[f] / 3] = static_cast<int>(f);
  plan(system);
}

void FieldTask::plan(const TissueSystem& system) {
  const int nodes = static_cast<int>(system.position.size()), batches = static_cast<int>(system.model.batches.size());
  const SparseCholesky& factor = system.factor;
  const auto each = [&](Work work, int count, double cost) { add(work, count, [&](int) { return cost; }); };
  for (const bool counting : {true, false}) {
    steps_.clear();
    const double all = std::exchange(cost_, 0);
    largest_step_ = counting ? 1e300 : kStepShare * all;
    parts_ = factor.parts(largest_step_);
    const int parts = static_cast<int>(parts_.size());
    each(Work::prepare, 1, kPrepareNode * nodes);
    each(Work::carry, nodes, kCarryNode);
    add(Work::backward, parts, [&](int i) { return kBackwardEntry * factor.entries(parts_[parts - 1 - i]); });
    each(Work::place, nodes, kPlaceNode);
    each(Work::elements, batches, kBatch);
    each(Work::turn, batches, kTurnBatch);
    each(Work::normalize, 1, kNormalizeNode * nodes);
    each(Work::gather, system.model.nodes(), kGatherNode);
    each(Work::smooth, system.model.nodes(), kSmoothNode);
    each(Work::defect, nodes, kDefectNode);
    each(Work::feed, nodes, kFeedNode);
    each(Work::project, nodes, kProjectNode);
    add(Work::forward, parts, [&](int i) { return factor.entries(parts_[i]); });
  }
}

template <class Cost>
void FieldTask::add(Work work, int count, Cost cost) {
  for (int first = 0; first < count;) {
    int last = first;
    double of_step = 0;
    do of_step += cost(last++);
    while (last < count && of_step + cost(last) <= largest_step_);
    cost_ += of_step;
    steps_.push_back({work, first, last, cost_});
    first = last;
  }
}

double FieldTask::largest_slice(int window) const {
  double largest = 0, before = 0;
  std::size_t step = 0;
  for (int tick = 0; tick < window; ++tick) {
    step = steps_until(tick, window);
    const double until = step == 0 ? 0 : steps_[step - 1].until;
    largest = std::max(largest, until - std::exchange(before, until));
  }
  return largest;
}

std::size_t FieldTask::steps_until(int tick, int window) const {
  const double due = cost_ * (tick + 1) / window;
  if (tick + 1 >= window) return steps_.size();
  const auto step = std::upper_bound(steps_.begin(), steps_.end(), due, [](double d, const Step& s) { return d < s.until; });
  return static_cast<std::size_t>(step - steps_.begin());
}

void FieldTask::begin(const std::shared_ptr<const FieldWindow>& window) {
  window_ = window;
  done_ = 0;
}

void FieldTask::advance(const TissueSystem& system, const ElementRotations& start, int tick) {
  for (const std::size_t until = steps_until(tick, system.field->window); done_ < until; ++done_)
    run(system, *window_, start, steps_[done_]);
}

bool FieldTask::finish(const TissueSystem& system, const ElementRotations& start, const std::atomic<bool>& stopped) {
  for (; done_ < steps_.size(); ++done_) {
    if (stopped.load(std::memory_order_relaxed)) return false;
    run(system, *window_, start, steps_[done_]);
  }
  return true;
}

void FieldTask::run(const TissueSystem& system, const FieldWindow& window, const ElementRotations& start, const Step& step) {
  const auto [work, first, last, until] = step;
  FieldWindow& next = *result_.window;
  switch (work) {
    case Work::prepare:
      return prepare(system, window);
    case Work::carry:
      return carry(window, 3 * first, 3 * last);
    case Work::backward:
      for (int i = first; i < last; ++i)
        system.factor.backward(parts_[parts_.size() - 1 - i], next.y_defect, panel_rows_);
      return;
    case Work::place:
      return place(system, window, first, last);
    case Work::elements:
      result_.inverted |= add_elastic_forces(system.model, first, last, start, result_.element_rotations, elements_);
      return;
    case Work::turn:
      if (first == 0) {
        next.rotations.setZero();
        one_sign_ = have_one_sign(system.model, result_.element_rotations);
      }
      return add_node_rotations(system.model, first, last, result_.element_rotations, one_sign_, next.rotations);
    case Work::normalize:
      normalize_rotations(next.rotations);
      one_sign_ = have_one_sign(next.rotations);
      return void(sums_.setZero());
    case Work::gather:
      return add_to_grid(system.rotation_grid, next.rotations, one_sign_, first, last, sums_);
    case Work::smooth:
      if (first == 0) normalize_grid(sums_);
      return take_from_grid(system.rotation_grid, sums_, one_sign_, first, last, next.rotations);
    case Work::defect:
      return find_defect(system, window, first, last);
    case Work::feed:
      if (first == 0) judge(system, window);
      return feed(window, 3 * first, 3 * last);
    case Work::project:
      for (int position = 3 * first; position < 3 * last; position += 3)
        system.field->project(position, next.defect.segment<3>(position), next.modes_defect);
      return;
    case Work::forward:
      for (int i = first; i < last; ++i) system.factor.forward(parts_[i], next.y_defect, panel_rows_);
      return;
  }
}

void FieldTask::prepare(const TissueSystem& system, const FieldWindow& window) {
  FieldWindow& next = *result_.window;
  const DeferredField& field = *system.field;
  std::fill(held_.begin(), held_.end(), -1);
  for (std::size_t i = 0; i < window.held.size(); ++i)
    held_[system.position[window.held[i].free] / 3] = static_cast<int>(i);
  next.begun = window.begun + static_cast<std::uint64_t>(field.window);
  next.y_defect = window.y_moved;
  next.modes_defect.setZero();
  next.left.setZero();
  shares_ = FieldShares::at_start();
  for (int tick = 0; tick < field.window; ++tick)
    shares_.advance(field.rho, field.window, window.begun == 0 && tick == 0);
  squares_ = applied_ = 0;
  result_.inverted = false;
  for (const int node : system.model.fixed_nodes) {
    elements_.x.col(node).head<3>() = result_.ahead.col(node) = next.x.col(node) = window.x.col(node);
    result_.v.col(node).setZero();
  }
  elements_.forces.setZero();
}

void FieldTask::carry(const FieldWindow& window, int first, int last) {
  FieldWindow& next = *result_.window;
  for (int i = first; i < last; ++i) {
    next.p[i] = shares_.carried * window.p[i] + shares_.fed * window.defect[i];
    next.y[i] = shares_.carried * window.y[i] + shares_.fed * window.y_defect[i];
    next.y_moved[i] = shares_.carried_sum * window.y[i] + shares_.fed_sum * window.y_defect[i];
  }
}

// The field, held nodes where they have come to.
void FieldTask::place(const TissueSystem& system, const FieldWindow& window, int first, int last) {
  FieldWindow& next = *result_.window;
  const DeferredField& field = *system.field;
  for (int at = first; at < last; ++at) {
    const int node = system.model.free_nodes[free_at_[at]], position = 3 * at;
    const Vector3 moved = next.y_defect.segment<3>(position) + field.motion(position, window.modes_moved);
    const Vector3 before = window.x.col(node);
    const Vector3 x =
        held_[at] >= 0 ? window.held[held_[at]].x : Vector3(before + rotation_of(window.rotations, node) * moved);
    elements_.x.col(node).head<3>() = next.x.col(node) = x;
    result_.ahead.col(node) = x + DeferredField::kAhead * (x - before);
    result_.v.col(node) = (x - before) / (field.window * field.h);
  }
}

void FieldTask::find_defect(const TissueSystem& system, const FieldWindow& window, int first, int last) {
  FieldWindow& next = *result_.window;
  const DeferredField& field = *system.field;
  for (int at = first; at < last; ++at) {
    const int node = system.model.free_nodes[free_at_[at]], position = 3 * at;
    const Quaternion turn = rotation_of(next.rotations, node);
    Vector3 applied = system.model.applied.col(node);
    Vector3 p = window.p.segment<3>(position);
    if (held_[at] >= 0) {
      applied += window.held[held_[at]].force;
      p += window.held[held_[at]].p;
    }
    const Vector3 missing = turn.conjugate() * (applied - elements_.forces.col(node).head<3>()) - field.rho * p -
                            window.defect.segment<3>(position) -
                            system.model.mass[node] * field.motion(position, window.inertia);
    const Vector3 total = window.scheduled.segment<3>(position) + missing;
    next.left += turn * missing;
    squares_ += missing.squaredNorm();
    applied_ += applied.squaredNorm();
    next.defect.segment<3>(position) = missing + window.increase * (total - window.total.segment<3>(position));
    next.total.segment<3>(position) = total;
  }
}

// Finds what share of the defect is fed in, and whether the field is to be stopped.
void FieldTask::judge(const TissueSystem& system, const FieldWindow& window) {
  FieldWindow& next = *result_.window;
  next.size = std::sqrt(squares_);
  next.scale = std::max(std::sqrt(applied_), kFading * window.scale);
  const auto beyond = [&](double growth, double part) {
    return !(next.size <= std::max({growth * window.size, part * next.scale, kLeast}));
  };
  next.grown = beyond(kGrowth, kPart) ? std::min(window.grown, kGrowing - 1) + 1 : 0;
  result_.stops = next.grown >= kGrowing || beyond(1, kMost);
  next.share = result_.stops ? std::max(kLeastShare, window.share / 2) : std::min(1.0, kComingBack * window.share);
  next.increase = result_.stops || next.share < 1 ? 0 : system.field->increase;
}

void FieldTask::feed(const FieldWindow& window, int first, int last) {
  FieldWindow& next = *result_.window;
  for (int i = first; i < last; ++i) {
    next.defect[i] *= next.share;
    next.y_defect[i] = next.defect[i];
    next.scheduled[i] = window.scheduled[i] + next.defect[i];
  }
}

FieldTask::Result& FieldTask::take() {
  begin(nullptr);
  return result_;
}

FieldState make_field_state(const TissueSystem& system, int most_held, const TissueState* in_equilibrium) {
  const int room = std::min(most_held, static_cast<int>(system.position.size()));
  const DeferredField& field = *system.field;
  const Eigen::Index unknowns = system.model.unknowns(), modes = field.modes.count();
  FieldWindow window;
  window.y_moved = window.defect = window.y_defect = VectorX::Zero(unknowns);
  window.modes_moved = window.inertia = window.modes_defect = window.modes = VectorX::Zero(modes);
  window.held = Bounded<HeldNode>(static_cast<std::size_t>(room));
  window.p.setZero(unknowns);
  if (in_equilibrium) {
    window.x = in_equilibrium->x;
    window.rotations = node_frames(system, in_equilibrium->rotations);
  } else {
    window.x = system.model.mesh->nodes;
    window.rotations.setZero(4, system.model.nodes());
    window.rotations.row(0).setOnes();
    for (std::size_t f = 0; f < system.position.size(); ++f)
      window.p.segment<3>(system.position[f]) = system.model.applied.col(system.model.free_nodes[f]);
  }
  window.y = window.scheduled = window.total = window.p;
  window.increase = field.increase;
  MatrixX panel_rows = system.factor.make_panel_rows();
  system.factor.forward(window.y, panel_rows);
  for (int position = 0; position < unknowns; position += 3)
    field.project(position, window.p.segment<3>(position), window.modes);
  FieldState state;
  state.held = window.held;
  state.d = state.d_before = state.modes_moved = VectorX::Zero(modes);
  state.window = std::make_shared<FieldWindow>(std::move(window));
  return state;
}

}  // namespace acus
