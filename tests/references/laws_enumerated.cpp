// SPDX-License-Identifier: GPL-3.0-or-later
// The laws' solvers against a dense oracle that tries every combination of pieces of the graphs (laws.h), to seven
// rows.
//
// The laws meet their lines in exactly one point, as the graphs are monotone and W is positive definite (R. W. Cottle,
// J.-S. Pang, R. E. Stone, "The Linear Complementarity Problem", 1992, Theorem 3.1.6: a symmetric positive definite
// matrix gives each complementarity problem one solution). So the oracle must find one consistent combination,
// and all that are consistent must be the same point. tests/laws holds well-conditioned systems against such an
// oracle; here the directions differ by up to 1e10 in compliance, and the oracle computes in extended precision.
//
// How far the answers may be off: the solvers end where no law is violated by more than 1e-10 of the largest force. A
// force of that size on the softest row moves the stiffest one as much as a force larger by the root of the ratio of
// their compliances does, so that is what the error of a stiff row can be.
//
// Friction of a contact is not associated, and its answer need not be unique (A. Klarbring, "Examples of non-uniqueness
// and non-existence of solutions to quasistatic contact problems with friction", Ingenieur-Archiv 60 (1990)): some
// random problems have more than one consistent point, and the solvers must be on one of them.
#include <doctest/doctest.h>

#include <numbers>

#include "tests/laws/law_problems.h"
#include "tests/references/figure.h"
#include "tests/support/dense.h"

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
      if (limit == kAll) return {{1, 0, 0, -kAll, kAll, 1}, {0, 1, 0, 0, limit, 0}};
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

// Every consistent point of a problem whose rows 0 to 2 are a contact with friction (laws.h, disk) and whose others are
// of one row. The contact is open, closed or capped; its disk sticks, or slides with its force at an angle a. Given a,
// all is linear, and a is right where the sliding is opposed to the force; such angles are bracketed on a grid.
class ContactEnumeration {
 public:
  explicit ContactEnumeration(const Problem& p) : p_(p) {
    for (const Piece& normal : pieces(p.laws[0]))
      for (const bool sticks : {true, false}) {
        choice_ = {normal};
        sticks_ = sticks;
        choose(3);
      }
  }
  const std::vector<VectorX>& points() const { return points_; }

 private:
  static constexpr int kAngles = 120;

  void choose(int row) {
    if (row == p_.rows()) return sticks_ ? keep(forces(0)) : find_angles();
    for (const Piece& piece : pieces(p_.laws[static_cast<std::size_t>(row)])) {
      choice_.resize(static_cast<std::size_t>(row - 2));
      choice_.push_back(piece);
      choose(row + 1);
    }
  }

  const Piece& piece_of(int row) const { return choice_[static_cast<std::size_t>(row == 0 ? 0 : row - 2)]; }
  double radius(const VectorX& lambda) const { return p_.laws[1].cohesion + p_.laws[1].limit * lambda[0]; }

  VectorX forces(double angle) const {
    MatrixX system = MatrixX::Zero(p_.rows(), p_.rows());
    VectorX rhs(p_.rows());
    for (int i = 0; i < p_.rows(); ++i) {
      const bool disk = i == 1 || i == 2;
      const double along = i == 1 ? std::cos(angle) : std::sin(angle);
      const Piece piece = !disk     ? piece_of(i)
                          : sticks_ ? Piece{0, 1, 0, 0, 0, 0}
                                    : Piece{1, 0, p_.laws[1].cohesion * along, 0, 0, 0};
      system.row(i) = piece.beta * p_.W.row(i);
      system(i, i) += piece.alpha;
      rhs[i] = piece.gamma - piece.beta * p_.delta_free[i];
      if (disk && !sticks_) system(i, 0) -= p_.laws[1].limit * along;
    }
    return test::solve_dense(system, rhs);
  }

  // The sliding across the disk's force; zero where they are in line.
  double across(double angle) const {
    const VectorX delta = p_.W * forces(angle) + p_.delta_free;
    return delta[2] * std::cos(angle) - delta[1] * std::sin(angle);
  }

  void find_angles() {
    for (int i = 0; i < kAngles; ++i) {
      double low = 2 * std::numbers::pi * i / kAngles, high = 2 * std::numbers::pi * (i + 1) / kAngles;
      const double at_low = across(low);
      if (at_low * across(high) > 0) continue;
      for (int bisection = 0; bisection < 60; ++bisection) {
        const double middle = (low + high) / 2;
        (at_low * across(middle) > 0 ? low : high) = middle;
      }
      keep(forces(low));
    }
  }

  void keep(const VectorX& lambda) {
    constexpr double kSlack = 1e-9;
    const VectorX delta = p_.W * lambda + p_.delta_free;
    for (int i = 0; i < p_.rows(); ++i) {
      if (i == 1 || i == 2) continue;
      const Piece& piece = piece_of(i);
      if (!(lambda[i] >= piece.least_lambda - kSlack && lambda[i] <= piece.most_lambda + kSlack)) return;
      if (piece.side * delta[i] < -kSlack) return;
    }
    const Eigen::Vector2d force = lambda.segment<2>(1), slip = delta.segment<2>(1);
    if (radius(lambda) < -kSlack || force.norm() > radius(lambda) + kSlack) return;
    if (!sticks_ && (slip.dot(force) > kSlack || std::abs(slip[1] * force[0] - slip[0] * force[1]) > kSlack)) return;
    points_.push_back(lambda);
  }

  const Problem& p_;
  std::vector<Piece> choice_;  // of row 0, then of rows 3 and on
  bool sticks_ = false;
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

TEST_CASE("a contact with friction, cohesion and a cap among up to two rows: both solvers are on a consistent point") {
  Random random(32);
  double off[2] = {0, 0};
  int without_point = 0, several = 0;
  for (int repeat = 0; repeat < 80; ++repeat) {
    Problem p;
    append_contact(p, random);
    const int others = random.index(3);
    for (int i = 0; i < others; ++i) p.laws.push_back(random_law(random));
    p.W = random_compliance(p.rows(), random);
    p.delta_free = random.matrix(p.rows(), 1);
    const std::vector<VectorX> points = ContactEnumeration(p).points();
    if (points.empty()) {
      ++without_point;
      continue;
    }
    double apart = 0;
    for (const VectorX& point : points) apart = std::max(apart, (point - points[0]).norm());
    if (apart > 1e-6) ++several;
    for (int m = 0; m < 2; ++m) {
      const VectorX found = solve(p, kBothMethods[m], {1000000, 1e-12}).lambda;
      double nearest = kInfinite;
      for (const VectorX& point : points) nearest = std::min(nearest, (found - point).norm());
      off[m] = std::max(off[m], nearest);
    }
  }
  CHECK(agrees("enumerated with a contact, problems without consistent point", 0, without_point, 0));
  CHECK(agrees("enumerated with a contact, of 80 problems those with several points", 0, several, 0));
  CHECK(agrees("enumerated with a contact, sweeps (N)", 0, off[0], 1e-9));
  CHECK(agrees("enumerated with a contact, direct (N)", 0, off[1], 1e-9));
}

TEST_CASE("a contact that may be open or jammed: both solvers leave it open") {
  // Sliding presses the tip into the surface (W_nt), as with a needle that leans into its way.
  Problem p;
  p.W = Matrix3{{0.2245, -0.2629, 0.3658}, {-0.2629, 1.1197, -0.98}, {0.3658, -0.98, 1.1547}};
  p.delta_free = Vector3(0.0104, -0.1917, 0.3569);
  p.laws = {{LawKind::unilateral, 1.97},
            {.kind = LawKind::disk_first, .limit = 0.687, .normal_row = 0},
            {.kind = LawKind::disk_second, .limit = 0.687, .normal_row = 0}};
  const std::vector<VectorX> points = ContactEnumeration(p).points();
  double most = 0;
  for (const VectorX& point : points) most = std::max(most, point[0]);
  CHECK(most > 0.1);
  for (const LawMethod method : kBothMethods) CHECK(solve(p, method).lambda.norm() < 1e-12);
}

}  // namespace
}  // namespace acus
