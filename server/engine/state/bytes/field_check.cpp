// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/bytes/field_check.h"

#include <cmath>
#include <vector>

namespace acus {

namespace {

constexpr double kRotationTolerance = 1e-3;  // of the rotations of nodes, which only turn forces
constexpr double kShareTolerance = 1e-9;     // of what the same operations give
constexpr double kImageTolerance = 1e-3;     // of sums of columns that are kept in few bits,
constexpr double kImageRest = 1e-6;          // and of StateBounds, where such sums have cancelled

// Those after the window's ticks so far.
FieldShares shares_of(const DeferredField& field, const FieldState& state) {
  const bool first = state.window->begun == 0;
  FieldShares shares = first ? FieldShares{} : FieldShares::at_start();
  for (int tick = 0; tick < state.tick; ++tick) shares.advance(field.rho, field.window, first && tick == 0);
  return shares;
}

bool close(const FieldShares& a, const FieldShares& b) {
  const auto same = [](double x, double y) { return std::abs(x - y) <= kShareTolerance * (1 + std::abs(y)); };
  return same(a.carried, b.carried) && same(a.fed, b.fed) && same(a.carried_sum, b.carried_sum) &&
         same(a.fed_sum, b.fed_sum);
}

// y = L⁻¹ f and modes = Phiᵀ f.
void check_images(const TissueSystem& system, const StateBounds& bounds, const VectorX& f, const VectorX& y,
                  const VectorX& modes, const std::string& what) {
  VectorX image = f, projected = VectorX::Zero(modes.size());
  MatrixX panel_rows = system.factor.make_panel_rows();
  system.factor.forward(image, panel_rows);
  for (const int position : system.position) system.field->project(position, f.segment<3>(position), projected);
  const auto same = [](const VectorX& a, const VectorX& b, double rest) {
    return (a - b).norm() <= kImageTolerance * b.norm() + kImageRest * rest;
  };
  require_in_range(same(y, image, bounds.y) && same(modes, projected, bounds.force), what);
}

void check_held(const Model& model, const Bounded<HeldNode>& held, const StateBounds& bounds, const std::string& what) {
  std::vector<bool> there(model.tissue.free_nodes.size());
  for (const HeldNode& node : held) {
    require_in_range(0 <= node.free && node.free < static_cast<int>(there.size()) && !there[node.free], what);
    there[node.free] = true;
    require_in_range(within(node.x - model.mesh.nodes.col(model.tissue.free_nodes[node.free]), bounds.way), what);
    require_in_range(within(node.p, bounds.force) && within(node.force, bounds.force), what);
    require_in_range(within(node.sum, bounds.force * model.scene.tissue.window), what);
  }
}

void check_window(const Model& model, const FieldWindow& window, const StateBounds& bounds) {
  const DeferredField& field = *model.tissue_system.field;
  const double ticks = field.window, size = bounds.force * std::sqrt(static_cast<double>(window.p.size()));
  require_in_range(window.grown >= 0 && window.share > 0 && window.share <= 1, "the share of a defect");
  require_in_range(0 <= window.increase && window.increase <= std::max(1.0, field.increase),
                   "the increase of a defect");
  require_in_range(0 <= window.size && window.size <= size && 0 <= window.scale && window.scale <= size,
                   "the size of a defect");
  for (const VectorX* forces : {&window.p, &window.defect, &window.scheduled, &window.total})
    require_in_range(within(*forces, bounds.force), "a force of a window");
  require_in_range(within(window.left, size * std::sqrt(static_cast<double>(window.p.size()))),
                   "what a defect sums up to");
  require_in_range(within(window.y_moved, ticks * bounds.y) && within(window.modes_moved, ticks * bounds.mode),
                   "the motion of a window");
  const double fastest = field.modes.count() == 0 ? 0 : field.modes.omega2.maxCoeff();
  require_in_range(within(window.inertia, bounds.mode * (field.beta / field.h * fastest + 2 / (field.h * field.h) +
                                                         field.alpha / field.h)),
                   "the inertia of a window");
  require_in_range(within(window.x - model.mesh.nodes, bounds.way), "a node's place in a window");
  for (int i = 0; i < model.mesh.node_count(); ++i)
    require_in_range(std::abs(window.rotations.col(i).norm() - 1) < kRotationTolerance, "the rotation of a node");
  check_held(model, window.held, bounds, "a node held when the window began");
  check_images(model.tissue_system, bounds, window.p, window.y, window.modes, "what the forces of a window move");
  check_images(model.tissue_system, bounds, window.defect, window.y_defect, window.modes_defect, "what a defect moves");
}

}  // namespace

void check_field(const Model& model, const FieldState& field, const StateBounds& bounds) {
  const DeferredField& constant = *model.tissue_system.field;
  require_in_range(0 <= field.tick && field.tick <= constant.window, "the tick of a window");
  require_in_range(field.window->begun + static_cast<std::uint64_t>(field.tick) == field.ticks,
                   "the ticks before a window");
  require_in_range(close(field.shares, shares_of(constant, field)), "the share of a window that acts");
  require_in_range(field.held.capacity() == field.window->held.capacity(), "the room for held nodes");
  require_in_range(within(field.d, bounds.mode) && within(field.d_before, bounds.mode) &&
                       within(field.modes_moved, constant.window * bounds.mode),
                   "the amplitude of a mode");
  check_held(model, field.held, bounds, "a held node");
  check_window(model, *field.window, bounds);
}

}  // namespace acus
