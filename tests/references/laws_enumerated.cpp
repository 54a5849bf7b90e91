// SPDX-License-Identifier: GPL-3.0-or-later
// The laws' solvers against a dense oracle that tries every combination of pieces of the graphs (laws.h), to seven
// rows.
//
// The laws meet their lines in exactly one point, as the graphs are monotone and W is positive definite (R. W. Cottle,
// J.-S. Pang, R. E. Stone, "The Linear Complementarity Problem", 1992, Theorem 3.1.6: a symmetric positive definite
// matrix gives each complementarity problem one solution). So the oracle must find one combination that is consistent,
// and all that are consistent must be the same point. tests/constraints holds well-conditioned systems against such an
// oracle; here the directions differ by up to 1e10 in compliance, and the oracle computes in extended precision.
//
// How far the answers may be off: the solvers end where no law is violated by more than 1e-10 of the largest force. A
// force of that size on the softest row moves the stiffest one as much as a force larger by the root of the ratio of
// their compliances does, so that is what the error of a stiff row can be.
#include <doctest/doctest.h>

#include "tests/constraints/law_problems.h"
#include "tests/references/figure.h"

namespace acus {
namespace {

// A piece of a one-row graph: alpha lambda + beta delta = gamma, valid on a stretch of it.
struct Piece {
  double alpha, beta, gamma;
  double least_lambda, most_lambda;  // N
  int side;                          // of delta that is allowed: -1, 0 (any), 1
};

std::vector<Piece> pieces(const Law& law) {
  constexpr double kAll = kInfinite;
  const double c = law.viscosity, limit = law.limit;
  switch (law.kind) {
    case LawKind::bilateral:
      return {{law.compliance, 1, 0, -kAll, kAll, 0}};
    case LawKind::unilateral:
      return {{1, 0, 0, -kAll, kAll, 1}, {0, 1, 0, 0, limit, 0}, {1, 0, limit, -kAll, kAll, -1}};
    default:
      return {{0, 1, 0, -limit, limit, 0}, {1, c, -limit, -kAll, kAll, 1}, {1, c, limit, -kAll, kAll, -1}};
  }
}

// Every consistent point of a problem of one-row laws, in extended precision.
class Enumeration {
 public:
  explicit Enumeration(const Problem& p) : p_(p), n_(p.rows()) {
    for (const Law& law : p.laws) pieces_.push_back(pieces(law));
    system_.resize(n_, n_);
    rhs_.resize(n_);
    choose(0);
  }
  const std::vector<VectorX>& points() const { return points_; }

 private:
  using Real = long double;
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

  void choose(int row) {
    if (row == n_) return solve();
    for (const Piece& piece : pieces_[static_cast<std::size_t>(row)]) {
      chosen_.resize(static_cast<std::size_t>(row));
      chosen_.push_back(piece);
      system_.row(row) = piece.beta * p_.W.row(row).cast<Real>();
      system_(row, row) += piece.alpha;
      rhs_[row] =
          static_cast<Real>(piece.gamma) - static_cast<Real>(piece.beta) * static_cast<Real>(p_.delta_free[row]);
      choose(row + 1);
    }
  }

  void solve() {
    // Rows of displacement are scaled to those of force.
    Matrix scaled = system_;
    Vector rhs = rhs_;
    for (int i = 0; i < n_; ++i) {
      const Real size = scaled.row(i).cwiseAbs().maxCoeff();
      scaled.row(i) /= size;
      rhs[i] /= size;
    }
    const Vector lambda = scaled.partialPivLu().solve(rhs);
    const Vector delta = p_.W.cast<Real>() * lambda + p_.delta_free.cast<Real>();
    const Real force_slack = 1e-12L * (1 + lambda.cwiseAbs().maxCoeff());
    for (int i = 0; i < n_; ++i) {
      const Piece& piece = chosen_[static_cast<std::size_t>(i)];
      const Real slack = force_slack * static_cast<Real>(p_.W(i, i));
      if (!(lambda[i] >= piece.least_lambda - force_slack && lambda[i] <= piece.most_lambda + force_slack)) return;
      if (piece.side * delta[i] < -slack) return;
    }
    points_.push_back(lambda.cast<double>());
  }

  const Problem& p_;
  int n_;
  std::vector<std::vector<Piece>> pieces_;
  std::vector<Piece> chosen_;
  Matrix system_;
  Vector rhs_;
  std::vector<VectorX> points_;
};

// The largest distance (of the largest force) of both methods from the oracle over random problems.
struct Distances {
  double between_points = 0, sweeps = 0, direct = 0;
  int without_point = 0;

  void add(const Problem& p) {
    const std::vector<VectorX> points = Enumeration(p).points();
    if (points.empty()) {
      ++without_point;
      return;
    }
    const double force = std::max(1.0, points[0].cwiseAbs().maxCoeff());
    for (const VectorX& other : points)
      between_points = std::max(between_points, (other - points[0]).cwiseAbs().maxCoeff() / force);
    const auto off = [&](LawMethod method) {
      return (solve(p, method, {1000000, 1e-12 * force}).lambda - points[0]).cwiseAbs().maxCoeff() / force;
    };
    sweeps = std::max(sweeps, off(LawMethod::gauss_seidel));
    direct = std::max(direct, off(LawMethod::direct));
  }
};

// W with compliances of rows that differ by up to `ratio`; displacements of the size that forces of 1 N make.
Problem spread_problem(double ratio, Random& random) {
  Problem p;
  const int n = 1 + random.index(7);
  VectorX scale(n);
  for (double& s : scale) s = std::pow(ratio, -random.uniform(0, 0.5));
  p.W = scale.asDiagonal() * random_compliance(n, random) * scale.asDiagonal();
  p.W = (p.W + p.W.transpose()).eval() / 2;
  p.delta_free = scale.cwiseProduct(random.matrix(n, 1));
  for (int i = 0; i < n; ++i) {
    Law law = random_law(random);
    law.viscosity /= p.W(i, i);
    law.compliance *= p.W(i, i);
    p.laws.push_back(law);
  }
  return p;
}

TEST_CASE("up to seven rows, compliances apart by 1 to 1e10: one consistent combination, and both solvers find it") {
  for (const double ratio : {1.0, 1e5, 1e10}) {
    Random random(31);
    Distances d;
    for (int repeat = 0; repeat < 300; ++repeat) d.add(spread_problem(ratio, random));
    const std::string name = "enumerated, compliances 1:" + std::to_string(static_cast<long>(ratio)) + ", ";
    CHECK(agrees(name + "problems without consistent combination", 0, d.without_point, 0));
    CHECK(agrees(name + "consistent combinations apart", 0, d.between_points, 1e-9));
    CHECK(agrees(name + "sweeps", 0, d.sweeps, 1e-10 * std::sqrt(ratio)));
    CHECK(agrees(name + "direct", 0, d.direct, 1e-10 * std::sqrt(ratio)));
  }
}

}  // namespace
}  // namespace acus
