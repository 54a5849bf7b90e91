// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/base_stiffness.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/factor/partial_cholesky.h"
#include "server/engine/math/rotation.h"
#include "server/engine/models/needle/needle_base.h"
#include "server/engine/state/capacities.h"

namespace acus {

namespace {

// What the end of a Normal's force is to those who feel it.
ModelLimit end_of(ContactKind kind, bool most) {
  if (!most) return ModelLimit::contact;
  switch (kind) {
    case ContactKind::surface:
    case ContactKind::border:
      return ModelLimit::puncture;
    case ContactKind::cut:
      return ModelLimit::cutting;
    default:
      return ModelLimit::contact;
  }
}

bool is_capped(ContactKind kind) { return end_of(kind, true) != ModelLimit::contact; }

constexpr double kRim = 1e-9;  // of a limit: what is nearer to it has reached it

// Whether a law of one row is between the ends of its graph.
bool is_between(const Law& law, double force) {
  const double most = (1 - kRim) * law.limit;
  return force < most && force > (law.kind == LawKind::friction ? -most : 0);
}

// Where a line a + b s reaches `end`, either way.
void meet(double a, double b, double end, ModelLimit limit, BaseStiffness& result) {
  if (b == 0) return;
  const double s = (end - a) / b;
  if (s >= 0 && s < result.forward) result.forward = s, result.forward_limit = limit;
  if (s <= 0 && -s < result.backward) result.backward = -s, result.backward_limit = limit;
}

// Where the slip of a cone ends, or where one that sticks begins to slip, either way along the line of its forces.
void meet_cone(const Rows::Cone& cone, const Eigen::Vector2d& slip, const Eigen::Vector2d& force,
               const Eigen::Vector2d& force_change, const Eigen::Vector2d& slip_change, BaseStiffness& result) {
  const double size = slip.norm(), T = cone.friction.law.threshold;
  if (size > 0) {
    meet(size, slip_change.dot(slip) / size, 0, ModelLimit::slip, result);
    return;
  }
  // Where the line leaves the circle or ellipse whose half the force is in, or the one of the other half.
  const auto exit = [&](double stretch, bool own, double way) {
    const Eigen::Vector2d axes(stretch, 1);
    const Eigen::Vector2d from = force.cwiseQuotient(axes), change = force_change.cwiseQuotient(axes);
    const double a = change.squaredNorm(), b = from.dot(change), rest = from.squaredNorm() - T * T;
    const double c = own ? std::min(0.0, rest) : rest;
    return a > 0 && b * b >= a * c ? (way * std::sqrt(b * b - a * c) - b) / a : kInfinity;
  };
  const double own = cone.friction.stretch(force[0]);
  for (const double way : {-1.0, 1.0}) {
    double s = exit(own, true, way);
    if (!std::isfinite(s)) continue;
    const double there = cone.friction.stretch(force[0] + s * force_change[0]);
    if (there != own) s = exit(there, false, way);
    if (std::isfinite(s)) meet(s, -1, 0, ModelLimit::slip, result);
  }
}

Eigen::Index most_free_unknowns(const Model& model) {
  int most = 0;
  for (const NeedleModel& needle : model.needles) most = std::max(most, needle.rigid ? 0 : 6 * needle.beams);
  return most;
}

// Contacts that may slide: of a tip on a surface, or along a border, of a hub, of every cell of its shaft, and between
// needles.
Eigen::Index most_slides(const Model& model) {
  Eigen::Index most = max_needle_contacts(model.scene);
  for (const Needle& needle : model.scene.needles) most += 2 + shaft_cells(needle);
  return most;
}

}  // namespace

BaseStiffnessSolver::BaseStiffnessSolver(const Model& model) {
  const Eigen::Index rows = model.max_rows, slides = most_slides(model);
  unknowns_.reserve(static_cast<std::size_t>(rows));
  slides_.reserve(static_cast<std::size_t>(slides));
  slid_.resize(rows, slides);
  shifts_.resize(rows, 6);
  forces_.resize(rows, 6);
  for (VectorX* x : {&unknown_, &moved_, &row_shift_, &row_force_}) x->resize(rows);
  follow_.resize(most_free_unknowns(model), 6);
}

void BaseStiffnessSolver::begin(Scratch& scratch) {
  room_ = scratch.rows.room();
  collect(scratch.rows);
  factorize(scratch.rows.compliance());
}

void BaseStiffnessSolver::collect(const Rows& rows) {
  unknowns_.clear();
  slides_.clear();
  for (int i = 0; i < rows.count(); ++i) {
    const Law& law = rows.law(i);
    const double force = rows.lambda()[i];
    int unknown = -1;
    const auto add = [&](double give) {
      unknown = static_cast<int>(unknowns_.size());
      unknowns_.push_back({.row = i, .other = i, .give = give});
    };
    if (const Rows::Cone* cone = rows.find_cone(i)) {
      collect_cone(*cone, rows.answer(*cone));
      i += cone->rows() - 1;
      continue;
    }
    if (law.kind == LawKind::bilateral) add(law.compliance);
    if (law.kind == LawKind::unilateral || law.kind == LawKind::friction) {
      if (is_between(law, force)) {
        add(0);
      } else if (law.viscosity > 0) {
        add(1 / law.viscosity);
      }
    }
    const bool disk = i + 1 < rows.count() && rows.law(i + 1).kind == LawKind::disk_first;
    if (disk && rows.law(i + 1).normal_row == i) collect_disk(rows, i + 1, unknown);
  }
}

void BaseStiffnessSolver::collect_cone(const Rows::Cone& cone, const DiskContact& answer) {
  const int first = cone.row, last = first + cone.rows() - 1;
  const SlipLaw& law = cone.friction.law;
  const Eigen::Vector2d axes(cone.friction.stretch(answer.force[0]), 1);
  const Eigen::Vector2d slip = axes.cwiseProduct(answer.slip);  // in which the ellipse is a circle
  const double size = slip.norm(), full = answer.slip.norm();
  if (size == 0) {
    for (int i = first; i <= last; ++i) unknowns_.push_back({.row = i, .other = i});
    return;
  }
  const Eigen::Vector2d way = slip / size;
  const double force = law.force(full), slope = law.slope(full);
  const auto add = [&](const Eigen::Vector2d& shares, double give) {
    unknowns_.push_back({first, last, axes[0] * shares[0], shares[1], give});
  };
  if (cone.turns && force > 0) add({-way.y(), way.x()}, size / force);
  if (slope > 0) add(way, size / (full * slope));
}

// `normal`: the unknown of the normal force, or -1 if that is given.
void BaseStiffnessSolver::collect_disk(const Rows& rows, int i, int normal) {
  const Law& law = rows.law(i);
  const Eigen::Vector2d force(rows.lambda()[i], rows.lambda()[i + 1]), slip(rows.delta()[i], rows.delta()[i + 1]);
  const double radius = law.cohesion + law.limit * std::max(rows.lambda()[law.normal_row], 0.0);
  const double size = force.norm();
  if (size < (1 - kRim) * radius) {
    unknowns_.push_back({.row = i, .other = i, .give = 0});
    unknowns_.push_back({.row = i + 1, .other = i + 1, .give = 0});
  } else if (size > 0) {
    const Eigen::Vector2d along = force / size;
    unknowns_.push_back(
        {.row = i, .other = i + 1, .share = -along.y(), .other_share = along.x(), .give = slip.norm() / size});
    const double mu = law.limit;
    if (normal >= 0 && mu > 0 && slides_.size() < slides_.capacity())
      slides_.push_back({normal, {.row = i, .other = i + 1, .share = mu * along.x(), .other_share = mu * along.y()}});
  }
}

void BaseStiffnessSolver::factorize(const Eigen::Ref<const MatrixX>& W) {
  const auto n = static_cast<Eigen::Index>(unknowns_.size());
  const auto of_rows = [&](const Unknown& u, int column) { return u.of(W.col(column)); };
  const auto between = [&](const Unknown& a, const Unknown& b) {
    return b.share * of_rows(a, b.row) + b.other_share * of_rows(a, b.other);
  };
  auto matrix = factor();
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = j; i < n; ++i) matrix(i, j) = between(unknowns_[i], unknowns_[j]);
    matrix(j, j) += unknowns_[j].give;
  }
  if (!partial_cholesky(matrix, n)) {  // as where two rows say the same
    unknowns_.clear();
    slides_.clear();
    return;
  }
  for (std::size_t k = 0; k < slides_.size(); ++k) {
    auto column = slid_.col(static_cast<Eigen::Index>(k)).head(n);
    for (Eigen::Index i = 0; i < n; ++i) column[i] = between(unknowns_[i], slides_[k].friction);
    solve(column, static_cast<Eigen::Index>(k));
  }
}

// x <- M⁻¹ x with the first slides; each adds a product of two vectors to the matrix [Sherman and Morrison 1950].
void BaseStiffnessSolver::solve(Eigen::Ref<VectorX> x, Eigen::Index slides) const {
  const Eigen::Index n = x.size();
  cholesky_solve(factor(), x);
  for (Eigen::Index k = 0; k < slides; ++k) {
    const int normal = slides_[static_cast<std::size_t>(k)].normal;
    const auto slid = slid_.col(k).head(n);
    const double share = x[normal] / (1 + slid[normal]);
    x -= share * slid;
  }
}

// The change of all rows' forces that keeps the laws where delta_free is shifted.
void BaseStiffnessSolver::answer(const Eigen::Ref<const VectorX>& shift, Eigen::Ref<VectorX> forces) {
  auto x = unknown_.head(static_cast<Eigen::Index>(unknowns_.size()));
  for (std::size_t i = 0; i < unknowns_.size(); ++i) x[static_cast<Eigen::Index>(i)] = -unknowns_[i].of(shift);
  solve(x, static_cast<Eigen::Index>(slides_.size()));
  forces.setZero();
  for (std::size_t i = 0; i < unknowns_.size(); ++i) unknowns_[i].add_to(forces, x[static_cast<Eigen::Index>(i)]);
  for (const Slide& slide : slides_) slide.friction.add_to(forces, x[slide.normal]);
}

// D; the free nodes' part of the needle is left in follow_.
void BaseStiffnessSolver::put_shifts(const Model& scene, const Scratch& scratch, int needle) {
  const NeedleModel& model = scene.needles[static_cast<std::size_t>(needle)];
  const NeedleScratch& motion = scratch.needles[static_cast<std::size_t>(needle)];
  auto follow = follow_.topRows(motion.dq.size());
  follow_base(model, motion, follow);
  int row_of_needle = 0;
  for (int i = 0; i < scratch.rows.count(); ++i) {
    shifts_.row(i).setZero();
    if (scratch.rows.row(i).acts_on(needle))
      shifts_.row(i) = follow_base(model, motion, row_of_needle++, follow).transpose();
  }
}

BaseStiffness BaseStiffnessSolver::compute(const Model& scene, const Scratch& scratch, int needle) {
  const Rows& rows = scratch.rows;
  const NeedleModel& model = scene.needles[static_cast<std::size_t>(needle)];
  const NeedleScratch& motion = scratch.needles[static_cast<std::size_t>(needle)];
  const Eigen::Index n = rows.count();
  put_shifts(scene, scratch, needle);
  for (int axis = 0; axis < 6; ++axis) answer(shifts_.col(axis).head(n), forces_.col(axis).head(n));
  BaseStiffness result;
  result.stiffness = -base_tangent(model, motion, follow_.topRows(motion.dq.size()));
  for (Eigen::Index i = 0; i < n; ++i) result.stiffness += shifts_.row(i).transpose() * forces_.row(i);
  result.stiffness.bottomRightCorner<3, 3>() += skew(motion.reaction.tail<3>()) / 2;
  look_for_limits(rows, scratch.contacts, motion.shape().frames[0].col(0), result);
  result.lasting = lasting_wrench(model, motion);
  sum_up_yields(rows, scratch.contacts, needle, result);
  return result;
}

void BaseStiffnessSolver::sum_up_yields(const Rows& rows, const Contacts& contacts, int needle, BaseStiffness& result) {
  for (const Contact& contact : contacts.found) {
    if (!contact.acts_on(needle) || contact.rows == 0) continue;
    const int i = contact.first_row;
    const double limit = rows.law(i).limit;
    if (std::holds_alternative<Along>(contact.hold)) {
      const Rows::Cone* cone = rows.find_cone(i);
      const double most = cone ? cone->friction.law.threshold : limit;
      result.forward_yield += most;
      result.backward_yield += cone ? cone->friction.back * most : most;
    } else if (is_capped(contact.kind) && rows.lambda()[i] > 0) {
      result.forward_yield += limit;
    } else if (contact.rows == 3 && !is_capped(contact.kind)) {  // slides on a surface or needle
      const double most = rows.law(i + 1).limit * rows.lambda()[i];
      result.forward_yield += most;
      result.backward_yield += most;
    }
  }
  result.forward_yield = std::min(result.forward_yield, kMostYield);
  result.backward_yield = std::min(result.backward_yield, kMostYield);
}

void BaseStiffnessSolver::look_for_limits(const Rows& rows, const Contacts& contacts, const Vector3& axis,
                                          BaseStiffness& result) {
  const Eigen::Index n = rows.count();
  auto force = row_force_.head(n), moved = moved_.head(n), shift = row_shift_.head(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    force[i] = forces_.row(i).head<3>().dot(axis);
    shift[i] = shifts_.row(i).head<3>().dot(axis);
  }
  const auto W = rows.compliance();
  moved = shift;
  for (Eigen::Index j = 0; j < n; ++j)
    if (force[j] != 0) moved += force[j] * W.col(j);
  for (const Contact& contact : contacts.found) {
    if (const Rows::Cone* cone = rows.find_cone(contact.first_row); cone != nullptr && contact.rows > 0) {
      const auto pair = [&](auto&& of) { return Eigen::Vector2d(of[cone->row], cone->turns ? of[cone->row + 1] : 0); };
      meet_cone(*cone, rows.answer(*cone).slip, pair(rows.lambda()), pair(force), pair(moved), result);
      continue;
    }
    for (int i = contact.first_row; i < contact.first_row + contact.rows; ++i) {
      const Law& law = rows.law(i);
      const bool slips = law.kind == LawKind::friction;
      if (rows.row(i).left_out || (law.kind != LawKind::unilateral && !slips)) continue;
      const double lambda = rows.lambda()[i];
      const auto end = [&](bool most) { return slips ? ModelLimit::slip : end_of(contact.kind, most); };
      if (!is_between(law, lambda)) {
        meet(rows.delta()[i], moved[i], 0, end(lambda > 0), result);
        continue;
      }
      meet(lambda, force[i], law.limit, end(true), result);
      meet(lambda, force[i], slips ? -law.limit : 0, end(false), result);
    }
  }
}

}  // namespace acus
