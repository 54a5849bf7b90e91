// SPDX-License-Identifier: MIT
// Small vectors and matrices of fixed size, with the few operations that haptic loops need. Their layout does not
// depend on compiler options, so that a program may be compiled with others than the library.
#pragma once

#include <array>
#include <cmath>

namespace acus::haptics {

template <int n>
struct Vector {
  std::array<double, n> at{};

  constexpr double& operator[](int i) { return at[static_cast<std::size_t>(i)]; }
  constexpr double operator[](int i) const { return at[static_cast<std::size_t>(i)]; }
  Vector& operator+=(const Vector& b) {
    for (int i = 0; i < n; ++i) (*this)[i] += b[i];
    return *this;
  }
  Vector& operator-=(const Vector& b) {
    for (int i = 0; i < n; ++i) (*this)[i] -= b[i];
    return *this;
  }
  Vector& operator*=(double s) {
    for (double& each : at) each *= s;
    return *this;
  }
  friend Vector operator+(Vector a, const Vector& b) { return a += b; }
  friend Vector operator-(Vector a, const Vector& b) { return a -= b; }
  friend Vector operator-(Vector a) { return a *= -1; }
  friend Vector operator*(double s, Vector a) { return a *= s; }
  friend Vector operator*(Vector a, double s) { return a *= s; }
  friend bool operator==(const Vector&, const Vector&) = default;
};

template <int n>
double dot(const Vector<n>& a, const Vector<n>& b) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

template <int n>
double norm(const Vector<n>& a) {
  return std::sqrt(dot(a, a));
}

// Row by row.
template <int n>
struct Matrix {
  std::array<double, n * n> at{};

  constexpr double& operator()(int i, int j) { return at[static_cast<std::size_t>(i * n + j)]; }
  constexpr double operator()(int i, int j) const { return at[static_cast<std::size_t>(i * n + j)]; }
  friend Vector<n> operator*(const Matrix& a, const Vector<n>& x) {
    Vector<n> y;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) y[i] += a(i, j) * x[j];
    return y;
  }
};

using Vector3 = Vector<3>;
using Vector6 = Vector<6>;  // of translation and rotation, or of force and torque
using Matrix6 = Matrix<6>;

inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

// Unit; turns vectors of one frame into another.
struct Quaternion {
  double w = 1, x = 0, y = 0, z = 0;

  Vector3 vector() const { return {{x, y, z}}; }
  Quaternion conjugate() const { return {w, -x, -y, -z}; }
  friend Quaternion operator*(const Quaternion& a, const Quaternion& b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
  }
  friend Vector3 operator*(const Quaternion& q, const Vector3& v) {
    const Vector3 t = 2 * cross(q.vector(), v);
    return v + q.w * t + cross(q.vector(), t);
  }
};

Quaternion normalized(const Quaternion& q);
// The rotation vector (rad) of the shortest way.
Vector3 rotation_vector(const Quaternion& q);
Quaternion rotation(const Vector3& rotation_vector);

struct Pose {
  Vector3 position;        // m
  Quaternion orientation;  // unit
};

// From one pose to another: translation (m) and rotation vector (rad), both in the frame that the poses are in.
Vector6 displacement(const Pose& from, const Pose& to);
Pose displaced(const Pose& from, const Vector6& by);

// N and N m, about the pose that it acts on.
struct Wrench {
  Vector3 force;
  Vector3 torque;
};

Vector6 joined(const Vector3& upper, const Vector3& lower);
inline Vector6 joined(const Wrench& wrench) { return joined(wrench.force, wrench.torque); }
Wrench wrench_of(const Vector6& joined);
// Both halves turned.
Vector6 turned(const Quaternion& q, const Vector6& v);

// A X = B for symmetric positive definite A, by Cholesky. False, and x untouched, if A is not.
template <int n>
bool solve(const Matrix<n>& a, const Vector<n>& b, Vector<n>& x) {
  Matrix<n> l;
  for (int j = 0; j < n; ++j)
    for (int i = j; i < n; ++i) {
      double sum = a(i, j);
      for (int k = 0; k < j; ++k) sum -= l(i, k) * l(j, k);
      if (i > j) {
        l(i, j) = sum / l(j, j);
      } else if (sum > 0) {
        l(j, j) = std::sqrt(sum);
      } else {
        return false;
      }
    }
  Vector<n> y;
  for (int i = 0; i < n; ++i) {
    y[i] = b[i];
    for (int k = 0; k < i; ++k) y[i] -= l(i, k) * y[k];
    y[i] /= l(i, i);
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) y[i] -= l(k, i) * y[k];
    y[i] /= l(i, i);
  }
  x = y;
  return true;
}

// Eigenvalues and, as columns, unit eigenvectors of a symmetric matrix, by Jacobi rotations: at most kSweeps of them.
struct Spectrum {
  Vector6 values;
  Matrix6 vectors;
};
Spectrum spectrum(Matrix6 symmetric);

}  // namespace acus::haptics
