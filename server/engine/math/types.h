// SPDX-License-Identifier: GPL-3.0-or-later
// Names for the few linear-algebra types that everything shares. SI units, world frame unless a name says otherwise.
#pragma once

#include <Eigen/Dense>

namespace acus {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;
using VectorX = Eigen::VectorXd;
using MatrixX = Eigen::MatrixXd;
using Matrix3X = Eigen::Matrix3Xd;
using Matrix4X = Eigen::Matrix4Xd;

// A frame: where its origin is and how its axes stand in the frame that the name of the variable tells.
struct Pose {
  Vector3 position = Vector3::Zero();                 // m
  Quaternion orientation = Quaternion::Identity();    // unit

  Vector3 operator*(const Vector3& p) const { return position + orientation * p; }
};

}  // namespace acus
