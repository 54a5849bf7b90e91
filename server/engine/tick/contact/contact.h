// SPDX-License-Identifier: GPL-3.0-or-later
// A contact: a point of a needle that is held to a foot, by a law, through springs that mesh or needle do not resolve.
// Finders fill contacts in (insertion/finding/tip_contacts.h, vertex_contacts.h, shaft_contact.h, hub.h; guides.h,
// needle_contact.h); add_contact() makes rows of them (laws/rows.h), and read_contact() takes the forces back: nothing
// else does.
//
//   Normal   one row along n that pushes, capped; with friction two more in a disk across n
//   Across   two rows across a path or guide that hold; near the path's strength one of them is friction (tearing.h)
//   Along    one row of friction along it, with torsional friction one more about it, in one cone
//
// Forces are those on the needle. Those of the last tick, in the contact's state, are the first guess for those of this
// one, and what the springs bear as it begins.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "server/engine/laws/friction_cone.h"
#include "server/engine/laws/rows.h"
#include "server/engine/math/bounded.h"
#include "server/engine/scene/scene.h"
#include "server/engine/state/needle/contact_state.h"

namespace acus {

enum class ContactKind : std::uint8_t {
  surface,        // the tip on the tissue's surface
  border,         // the tip on a border inside
  cut,            // the tip against its path's end
  tip,            // the tip across its path
  tip_support,    // the tip beside bone that its path lies on
  vertex,         // the shaft across its path, and along it
  shaft_support,  // the shaft beside bone that its path lies on
  shaft,          // the shaft on a surface beside its path
  hub,            // the hub on the surface around its path's mouth
  guide,
  needles
};

// What holds the needle: the tissue's material, a point of it or more, or another needle; else the world.
struct Foot {
  TissuePoint point{};
  std::span<const MaterialPoint> patch{};  // not empty: in place of the point; weights together sum to 1
  int needle = -1;
  CurvePoint on_needle{};
};

// A nonlinear spring under the force of the last tick.
struct Spring {
  double depth = 0;       // m
  double compliance = 0;  // m/N, of small changes
  double stored = 0;      // J, less that of the compliance alone
};

struct DiskFriction {
  Vector3 slip = Vector3::Zero();  // m, world, in this tick
  double friction = 0;             // mu (-)
  double cohesion = 0;             // N
  double compliance = 0;           // m/N, of a spring across n
};

struct Normal {
  Vector3 n = Vector3::UnitZ();  // unit, world
  double gap = 0;                // m, along n; of springs linear in the force, what they bear is taken off
  double most = kInfinity;       // N
  double before = 0;             // N, in the last tick
  double compliance = 0;         // m/N, of linear springs
  Spring spring{};
  std::optional<DiskFriction> friction{};
};

// Rows across a path that may tear in this tick.
struct TearLimit {
  Vector3 along;  // unit, world, across the path: the direction of the force
  double force;   // N, the threshold
};

struct Across {
  Vector3 tangent = Vector3::UnitX();  // of the path or guide, unit, world
  Vector3 apart = Vector3::Zero();     // m, world, of the needle from its foot
  double compliance = 0;               // m/N
  std::optional<TearLimit> tear{};
};

struct Along {
  Vector3 tangent = Vector3::UnitX();  // likewise
  double slip = 0;                     // m, in this tick, less what the spring bears
  double compliance = 0;               // m/N
  FrictionCone friction{};
  double radius = 0;  // m, at which torsional friction acts, 0: none
  double turned = 0;  // m, the slip about the needle there
};

struct Contact {
  ContactKind kind{};
  int needle = 0;
  CurvePoint on_needle{};
  Foot foot{};
  std::variant<Normal, Across, Along> hold{};
  ContactState* state = nullptr;  // null: it begins each tick at 0
  int first_row = 0, rows = 0;    // that it has, since add_contact()

  bool acts_on(int of_needles) const { return needle == of_needles || foot.needle == of_needles; }
};

// Those of a tick.
struct Contacts {
  Bounded<Contact> found;
  bool left_out = false;  // more than there is room for

  explicit Contacts(int capacity) : found(static_cast<std::size_t>(capacity)) {}
  void clear() { found.clear(), left_out = false; }
  void put(const Contact& contact) {
    if (found.full())
      left_out = true;
    else
      found.push_back(contact);
  }
};

// The forces on one needle by law; N, world. cutting + friction + lateral is the whole force of the tissue.
struct NeedleForces {
  Vector3 tip = Vector3::Zero();       // of the tissue on the tip: cutting or contact, and lateral
  Vector3 cutting = Vector3::Zero();   // of cutting, and of contact with a surface or border
  Vector3 friction = Vector3::Zero();  // along the path, whole shaft; along surfaces that the shaft lies on
  Vector3 lateral = Vector3::Zero();   // across the path, shaft and tip; of those surfaces on the shaft
  Vector3 guides = Vector3::Zero();
  Vector3 needles = Vector3::Zero();
  double amounts = 0;  // N, of all rows of the tissue but torsion, added up
};

// Stage 5. False if a row did not fit. The contact stays where it is until its forces are read.
bool add_contact(Contact& contact, Rows& rows);

// After the solve: adds the contact's forces to those of its state, and of its needles.
void read_contact(const Rows& rows, const Contact& contact, std::span<NeedleForces> forces);

// Whether a Normal's force has reached its cap.
bool at_most(const Rows& rows, const Contact& contact);

}  // namespace acus
