// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/bytes/state_bounds.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

constexpr double kStrain = 100;  // of the whole tissue

double largest(const Scene& scene, double Material::*number) {
  double most = 0;
  for (const Region& region : scene.tissue.regions) most = std::max(most, region.material.*number);
  return most;
}

double diagonal(const Matrix3X& nodes) {
  return nodes.cols() == 0 ? 0 : (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
}

}  // namespace

// A force acts on tissue that bears it: it strains all of it, if no more.
StateBounds::StateBounds(const Model& model) {
  const double size = diagonal(model.mesh.nodes), density = largest(model.scene, &Material::density);
  way = kStrain * size;
  force = kStrain * largest(model.scene, &Material::young_modulus) * size * size;
  y = std::sqrt(force * way);
  mode = way * std::sqrt(density * size * size * size);
}

}  // namespace acus
