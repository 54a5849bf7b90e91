// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/references/siconos_problems.h"

#include <siconos/numerics/FrictionContactProblem.h>
#include <siconos/numerics/Friction_cst.h>
#include <siconos/numerics/NonSmoothDrivers.h>
#include <siconos/numerics/NumericsMatrix.h>
#include <siconos/numerics/RelayProblem.h>
#include <siconos/numerics/Relay_Solvers.h>
#include <siconos/numerics/SolverOptions.h>
#include <siconos/numerics/relay_cst.h>

#include <memory>

#include "tests/support/dense.h"

namespace acus {
namespace {

// Stands for an unbounded force, which the relay problem has no word for.
constexpr double kUnbounded = 1e3;  // N

struct OptionsDeleter {
  void operator()(SolverOptions* options) const { solver_options_delete(options); }
};
using Options = std::unique_ptr<SolverOptions, OptionsDeleter>;

Options make_options(int solver, int iterations, double tolerance) {
  Options options(solver_options_create(solver));
  options->iparam[SICONOS_IPARAM_MAX_ITER] = iterations;
  options->dparam[SICONOS_DPARAM_TOL] = tolerance;
  return options;
}

// A view of a dense matrix, which must outlive it.
struct MatrixDeleter {
  void operator()(NumericsMatrix* matrix) const {
    matrix->matrix0 = nullptr;
    NM_clear(matrix);
    std::free(matrix);
  }
};
using MatrixView = std::unique_ptr<NumericsMatrix, MatrixDeleter>;

MatrixView view(MatrixX& m) {
  return MatrixView(NM_create_from_data(NM_DENSE, static_cast<int>(m.rows()), static_cast<int>(m.cols()), m.data()));
}

// The bilateral rows, or the others.
Eigen::VectorXi rows_of(const Problem& p, bool bilateral) {
  Eigen::VectorXi rows(p.rows());
  int count = 0;
  for (int i = 0; i < p.rows(); ++i)
    if ((p.laws[static_cast<std::size_t>(i)].kind == LawKind::bilateral) == bilateral) rows[count++] = i;
  return rows.head(count);
}

// A problem without its bilateral rows, which give way by their compliance.
struct Reduced {
  Eigen::VectorXi held, others;  // rows of the problem
  MatrixX W;
  VectorX delta_free;

  explicit Reduced(const Problem& p) : held(rows_of(p, true)), others(rows_of(p, false)) {
    holding_ = p.W(held, held);
    for (Eigen::Index i = 0; i < held.size(); ++i)
      holding_(i, i) += p.laws[static_cast<std::size_t>(held[i])].compliance;
    across_ = p.W(others, held);
    held_free_ = p.delta_free(held);
    W = p.W(others, others) - across_ * test::solve_dense(holding_, across_.transpose());
    delta_free = p.delta_free(others) - across_ * test::solve_dense(holding_, held_free_);
  }

  VectorX all_forces(const VectorX& forces_of_others) const {
    VectorX lambda(held.size() + others.size());
    lambda(others) = forces_of_others;
    lambda(held) = -test::solve_dense(holding_, held_free_ + across_.transpose() * forces_of_others);
    return lambda;
  }

 private:
  MatrixX holding_, across_;
  VectorX held_free_;
};

}  // namespace

std::optional<VectorX> solve_relay(const Problem& p) {
  const Reduced reduced(p);
  const Eigen::Index n = reduced.others.size();
  VectorX low(n), high(n), viscosity(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Law& law = p.laws[static_cast<std::size_t>(reduced.others[i])];
    high[i] = std::min(law.limit, kUnbounded);
    low[i] = law.kind == LawKind::unilateral ? 0 : -high[i];
    viscosity[i] = law.viscosity;
  }
  const MatrixX slowed = MatrixX::Identity(n, n) + reduced.W * viscosity.asDiagonal();
  MatrixX m = test::solve_dense(slowed, reduced.W);
  VectorX q = test::solve_dense(slowed, reduced.delta_free), tau = VectorX::Zero(n), delta = VectorX::Zero(n);

  const MatrixView matrix = view(m);
  RelayProblem problem{static_cast<int>(n), matrix.get(), q.data(), low.data(), high.data()};
  const Options options = make_options(SICONOS_RELAY_LEMKE, 10000, 1e-9);
  if (relay_driver(&problem, tau.data(), delta.data(), options.get()) != 0) return std::nullopt;
  if (tau.cwiseAbs().maxCoeff() >= kUnbounded) return std::nullopt;
  return reduced.all_forces(tau - viscosity.cwiseProduct(m * tau + q));
}

std::optional<VectorX> solve_contacts(const Problem& p) {
  Reduced reduced(p);
  const int contacts = static_cast<int>(reduced.others.size()) / 3;
  VectorX mu(contacts);
  for (int c = 0; c < contacts; ++c) mu[c] = p.laws[static_cast<std::size_t>(reduced.others[3 * c + 1])].limit;
  VectorX reaction = VectorX::Zero(3 * contacts), velocity = reaction;

  const MatrixView matrix = view(reduced.W);
  FrictionContactProblem problem{3, contacts, matrix.get(), reduced.delta_free.data(), mu.data()};
  const Options options = make_options(SICONOS_FRICTION_3D_NSGS, 200000, 1e-13);
  if (fc3d_driver(&problem, reaction.data(), velocity.data(), options.get()) != 0) return std::nullopt;
  return reduced.all_forces(reaction);
}

}  // namespace acus
