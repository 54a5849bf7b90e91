// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/field/field_tick.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace acus {

namespace {

int count_of(const FieldState& state) { return static_cast<int>(state.held.size()); }

int node_of(const TissueSystem& system, const HeldNode& held) { return system.model.free_nodes[held.free]; }
int position_of(const TissueSystem& system, const HeldNode& held) { return system.position[held.free]; }

// out += G f over all slots; sums are in the order of the calls.
void add_product(const Corridor& corridor, int slot, const Vector3& f, VectorX& out) {
  const int dofs = 3 * corridor.used();
  const auto gram = corridor.gram().block(0, 3 * slot, dofs, 3);
  out.head(dofs) += f[0] * gram.col(0) + f[1] * gram.col(1) + f[2] * gram.col(2);
}

std::shared_ptr<FieldWindow> spare_window(FieldScratch& field) {
  for (auto& window : field.windows)
    if (window.use_count() == 1) return window;
  // Somebody keeps states of many windows.
  auto& oldest = *std::ranges::min_element(field.windows, {}, [](const auto& window) { return window->begun; });
  return oldest = std::make_shared<FieldWindow>(*oldest);
}

void forget_numbers(FieldScratch& field) {
  for (const HeldNode& held : field.now.held) field.held_of[held.free] = -1;
}

// Numbers of the held nodes and their slots; those of another list have been forgotten.
void list_held(TissueScratch& scratch) {
  FieldScratch& field = *scratch.field;
  Corridor& corridor = scratch.rows->corridor();
  std::fill(field.held_in.begin(), field.held_in.end(), -1);
  field.slots.clear();
  for (int i = 0; i < count_of(field.now); ++i) {
    const int free = field.now.held[i].free, slot = corridor.slot(free);
    assert(slot >= 0);
    field.held_of[free] = i;
    field.held_in[slot] = i;
    field.slots.push_back(slot);
  }
}

void read_window(const Corridor& corridor, int i, FieldScratch& field) {
  const FieldWindow& window = *field.now.window;
  field.moved_by_p.col(i) = corridor.free_displacement(field.slots[i], window.y);
  field.moved_by_defect.col(i) = corridor.free_displacement(field.slots[i], window.y_defect);
}

void read_window(TissueScratch& scratch) {
  FieldScratch& field = *scratch.field;
  if (field.read != field.now.window) field.read_of.clear();
  field.read = field.now.window;
  field.read_of.resize(std::min(field.read_of.size(), field.now.held.size()));
  for (int i = 0; i < count_of(field.now); ++i) {
    const int free = field.now.held[i].free;
    if (i < static_cast<int>(field.read_of.size()) && field.read_of[i] == free) continue;
    field.read_of.resize(static_cast<std::size_t>(i));
    field.read_of.push_back(free);
    read_window(scratch.rows->corridor(), i, field);
  }
}

// Phiᵀ p of the held nodes.
void add_modes(const TissueSystem& system, const HeldNode& held, const Vector3& f, VectorX& modes) {
  system.field->project(position_of(system, held), f, modes);
}

// p of a held node that no force has acted on for a window is the field's from here on.
void let_go(const TissueSystem& system, TissueScratch& scratch, FieldWindow& next) {
  FieldScratch& field = *scratch.field;
  FieldState& now = field.now;
  const Corridor& corridor = scratch.rows->corridor();
  const std::uint64_t before = now.ticks - std::min<std::uint64_t>(now.ticks, static_cast<std::uint64_t>(system.field->window));
  forget_numbers(field);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < now.held.size(); ++i) {
    const HeldNode held = now.held[i];
    if (held.used > before || !held.force.isZero(0)) {
      now.held[kept++] = held;
      continue;
    }
    next.p.segment<3>(position_of(system, held)) += held.p;
    corridor.add_force(field.slots[i], held.p, next.y);
    corridor.add_force(field.slots[i], held.sum, next.y_moved);
    add_modes(system, held, held.p, next.modes);
  }
  now.held.resize(kept);
  list_held(scratch);
}

// What the kept ones have moved goes into the field, and what this one moves them: each one's columns, which come from
// far away in memory, once.
void go_on_with_held(TissueScratch& scratch, FieldWindow& next) {
  FieldScratch& field = *scratch.field;
  field.read = field.now.window;
  field.read_of.clear();
  for (int i = 0; i < count_of(field.now); ++i) {
    HeldNode& held = field.now.held[i];
    scratch.rows->corridor().add_force(field.slots[i], held.sum, next.y_moved);
    held.sum.setZero();
    read_window(scratch.rows->corridor(), i, field);
    field.read_of.push_back(held.free);
  }
  next.held = field.now.held;
}

// Nothing moves, and nothing is under way.
void stop(FieldState& now, FieldWindow& next) {
  for (VectorX* part : {&next.p, &next.y, &next.modes, &next.scheduled, &now.d, &now.d_before, &next.defect,
                        &next.y_defect, &next.modes_defect, &next.total})
    part->setZero();
  for (HeldNode& held : now.held) held.p.setZero();
}

// The next window, of what this one has come to.
void cross(const TissueSystem& system, const TissueState& state, TissueScratch& scratch) {
  const DeferredField& model = *system.field;
  FieldScratch& field = *scratch.field;
  FieldState& now = field.now;
  const std::shared_ptr<const FieldWindow> last = now.window;
  field.worker.advance(last, state.rotations, model.window - 1);
  FieldTask::Result& result = field.worker.take();
  FieldWindow& next = *result.window;
  next.modes = now.shares.carried * last->modes + now.shares.fed * last->modes_defect;
  next.modes_moved = now.modes_moved;
  if (result.stops) stop(now, next);
  VectorX& p = field.modes;
  p = next.modes;
  for (std::size_t i = 0; i < now.held.size(); ++i) {
    HeldNode& held = now.held[i];
    const int node = node_of(system, held);
    const Quaternion turn = rotation_of(next.rotations, node).conjugate() * rotation_of(last->rotations, node);
    held.p = turn * held.p;
    held.sum = turn * held.sum;
    add_modes(system, held, held.p, p);
  }
  next.inertia = model.beta / model.h * model.modes.omega2.cwiseProduct(now.d - model.theta0.cwiseProduct(p)) +
                 (now.d - now.d_before) / (model.h * model.h) + model.alpha / model.h * now.d;
  let_go(system, scratch, next);
  std::swap(scratch.x, result.ahead);
  for (const HeldNode& held : now.held) scratch.x.col(node_of(system, held)) = held.x;
  std::swap(field.v, result.v);
  std::swap(scratch.element_rotations.batches, result.element_rotations.batches);
  scratch.inverted = result.inverted;
  now.window = std::exchange(result.window, spare_window(field));
  field.worker.follow(now.window);
  go_on_with_held(scratch, next);
  now.modes_moved.setZero();
  now.tick = 0;
  now.shares = FieldShares::at_start();
  field.crossed = true;
}

// Without the rows' forces, of one held node.
Vector3 free_motion(const TissueSystem& system, int i, const FieldScratch& field) {
  return field.products.segment<3>(3 * field.slots[i]) + field.shares.carried * field.moved_by_p.col(i) +
         field.shares.fed * field.moved_by_defect.col(i) +
         system.field->motion(position_of(system, field.now.held[i]), field.shift);
}

}  // namespace

void begin_field(const TissueSystem& system, const TissueState& state, TissueScratch& scratch) {
  FieldScratch& field = *scratch.field;
  for (std::size_t i = 0; i < field.now.held.size(); ++i) scratch.step.col(node_of(system, field.now.held[i])).setZero();
  forget_numbers(field);
  field.now = *state.field;
  if (std::ranges::find(field.windows, field.now.window) == field.windows.end()) field.foreign = field.now.window;
  field.crossed = false;
  list_held(scratch);
  if (field.now.tick == system.field->window) cross(system, state, scratch);
  read_window(scratch);
  field.moved.leftCols(count_of(field.now)).setZero();
}

void move_field_freely(const TissueSystem& system, const TissueState& state, TissueScratch& scratch) {
  const DeferredField& model = *system.field;
  FieldScratch& field = *scratch.field;
  FieldState& now = field.now;
  const FieldWindow& window = *now.window;
  if (scratch.iteration == 0) {
    if (state.moved) scratch.balance = {state.support - system.applied, system.applied, state.inertia};
    field.worker.advance(now.window, field.crossed ? scratch.element_rotations : state.rotations, now.tick);
    field.shares = now.shares;
    field.shares.advance(model.rho, model.window, now.ticks == 0);
    VectorX &changed = field.modes, &of_held = field.of_held;
    changed = (field.shares.carried - model.rho * now.shares.carried) * window.modes +
              (field.shares.fed - model.rho * now.shares.fed) * window.modes_defect;
    of_held.setZero();
    field.products.setZero();
    for (int i = 0; i < count_of(now); ++i) {
      const HeldNode& held = now.held[i];
      const Vector3 last = node_rotation(scratch, node_of(system, held)).conjugate() * held.force;
      const Vector3 p = model.rho * held.p - last;
      field.p_free.col(i) = p;
      add_modes(system, held, -last, changed);
      add_modes(system, held, p, of_held);
      add_product(scratch.rows->corridor(), field.slots[i], p, field.products);
    }
    field.d_free = model.theta1.cwiseProduct((now.d - now.d_before) / (model.h * model.h) + model.c1 * now.d +
                                             (model.c2 - 1) * model.modes.omega2.cwiseProduct(now.d) + changed);
    field.shift =
        field.d_free - model.theta1.cwiseProduct(of_held) -
        model.theta0.cwiseProduct(field.shares.carried * window.modes + field.shares.fed * window.modes_defect);
    for (int i = 0; i < count_of(now); ++i) field.free_motion.col(i) = free_motion(system, i, field);
  }
  for (int i = 0; i < count_of(now); ++i)
    scratch.rows->displacements().col(field.slots[i]) = field.free_motion.col(i) - field.moved.col(i);
}

bool hold_node(const TissueSystem& system, int free, TissueScratch& scratch) {
  FieldScratch& field = *scratch.field;
  FieldState& now = field.now;
  if (const int known = field.held_of[free]; known >= 0) {
    now.held[known].used = now.ticks + 1;
    return true;
  }
  Corridor& corridor = scratch.rows->corridor();
  const int slot = now.held.full() ? -1 : corridor.slot(free);
  if (slot < 0) return false;
  const FieldWindow& window = *now.window;
  const int i = count_of(now), node = system.model.free_nodes[free], position = system.position[free];
  now.held.push_back({.free = free, .used = now.ticks + 1});
  field.held_of[free] = i;
  field.held_in[slot] = i;
  field.slots.push_back(slot);
  field.read_of.push_back(free);
  read_window(corridor, i, field);
  // Where it has come to: the window before, then the ticks of this one.
  Vector3 way = corridor.free_displacement(slot, window.y_moved) + now.shares.carried_sum * field.moved_by_p.col(i) +
                now.shares.fed_sum * field.moved_by_defect.col(i);
  field.of_held.setZero();
  const auto gram = [&](int other) { return corridor.gram().block<3, 3>(3 * slot, 3 * field.slots[other]); };
  Vector3 product = Vector3::Zero();
  for (int other = 0; other < i; ++other) {
    way += gram(other) * now.held[other].sum;
    product += gram(other) * field.p_free.col(other);
    add_modes(system, now.held[other], now.held[other].sum, field.of_held);
  }
  field.modes = now.modes_moved + window.modes_moved +
                (system.field->theta0 - system.field->theta1).cwiseProduct(field.of_held);  // which G lacks
  way += system.field->motion(position, field.modes);
  now.held.back().x = scratch.x.col(node) = window.x.col(node) + node_rotation(scratch, node) * way;
  field.p_free.col(i).setZero();
  field.moved.col(i).setZero();
  field.products.segment<3>(3 * slot) = product;
  field.free_motion.col(i) = scratch.rows->displacements().col(slot) = free_motion(system, i, field);
  return true;
}

void solve_field(const TissueSystem& system, std::span<const double> lambda, TissueScratch& scratch) {
  FieldScratch& field = *scratch.field;
  TissueRows& rows = *scratch.rows;
  const int count = count_of(field.now);
  field.force.leftCols(count).setZero();
  field.products.setZero();
  rows.gather_forces(lambda);
  for (const int slot : rows.touched()) {
    field.force.col(field.held_in[slot]) = rows.slot_force(slot);
    add_product(rows.corridor(), slot, rows.slot_force(slot), field.products);
  }
  for (int i = 0; i < count; ++i) {
    const int node = node_of(system, field.now.held[i]);
    field.step.col(i) = field.free_motion.col(i) - field.moved.col(i) + field.products.segment<3>(3 * field.slots[i]);
    scratch.step.col(node) = node_rotation(scratch, node) * field.step.col(i);
  }
}

double move_field(const TissueSystem& system, double share, TissueScratch& scratch) {
  FieldScratch& field = *scratch.field;
  double largest = 0;
  for (int i = 0; i < count_of(field.now); ++i) {
    const int node = node_of(system, field.now.held[i]);
    field.moved.col(i) += share * field.step.col(i);
    scratch.x.col(node) += share * scratch.step.col(node);
    largest = std::max(largest, share * scratch.step.col(node).cwiseAbs().maxCoeff());
  }
  return largest;
}

void commit_field(const TissueSystem& system, TissueScratch& scratch, TissueState& state) {
  const DeferredField& model = *system.field;
  FieldScratch& field = *scratch.field;
  FieldState& now = field.now;
  const FieldWindow& window = *now.window;
  if (field.crossed) {
    std::swap(state.v, field.v);
    state.x = scratch.x;
    std::swap(state.rotations.batches, scratch.element_rotations.batches);
  }
  VectorX &modes = field.modes, &by_rows = field.of_held;
  modes = field.shares.carried * window.modes + field.shares.fed * window.modes_defect;
  by_rows.setZero();
  Vector3 on_tissue = scratch.lambda_on_fixed;
  for (int i = 0; i < count_of(now); ++i) {
    HeldNode& held = now.held[i];
    const int node = node_of(system, held);
    const Quaternion turn = node_rotation(scratch, node);
    held.p = field.p_free.col(i) + field.force.col(i);
    held.sum += held.p;
    held.force = turn * field.force.col(i);
    held.x = state.x.col(node) = scratch.x.col(node);
    state.v.col(node) = turn * field.moved.col(i) / model.h;
    on_tissue += held.force;
    add_modes(system, held, held.p, modes);
    add_modes(system, held, field.force.col(i), by_rows);
  }
  now.d_before = now.d;
  now.d = field.d_free + model.theta1.cwiseProduct(by_rows);
  now.modes_moved += now.d - model.theta0.cwiseProduct(modes);
  now.shares = field.shares;
  ++now.tick;
  ++now.ticks;
  state.support = -on_tissue;
  state.inertia = -window.left;
  state.moved = true;
  *state.field = now;
}

void hold_ahead(const TissueSystem& system, std::span<const int> tetrahedra, TissueScratch& scratch, TissueState& state) {
  for (const int tetrahedron : tetrahedra) {
    if (tetrahedron < 0) continue;
    for (const int node : system.model.mesh->tetrahedra[tetrahedron]) {
      const int free = system.model.free_index[node];
      if (free >= 0 && hold_node(system, free, scratch)) state.x.col(node) = scratch.x.col(node);
    }
  }
  state.field->held = scratch.field->now.held;
}

}  // namespace acus
