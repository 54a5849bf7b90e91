// SPDX-License-Identifier: MIT
// What a needle that hangs on a virtual coupling answers at once, without asking the server: the local model of one
// tick, prepared when it comes and evaluated at every sample of the device.
//
// The device drags the base of a massless needle (the proxy) by springs Kc, diagonal, in the base's own frame. With the
// base's place p0 and wrench F0 of the tick, its stiffness -A, the device at x, the proxy at p and q = p - p0,
//
//   Kc (x - p) + F = 0,   F = F0 - A (q - a e),   so that   (Kc + A) q = Kc (x - p0) + F0 + a A e.
//
// A is the symmetric part of what came, without what would push away (negative eigenvalues). e is the base's x axis.
// Along it what A sees, q - a e, ends at -backward and +forward, and the force stays as it is beyond. Where the limit
// is one that yields (slip, cutting, puncture), the proxy that goes beyond takes the spring's place of rest, a, along:
// when it turns back, the force falls at once, as friction's does. `pass` does the same for places that the proxy was
// sent to and that the model does not know of yet. A limit of contact leaves a where it is, and beyond it nothing but
// the needle's weight is felt and the proxy is where the device is.
//
// A tick in which the needle slides has no stiffness along its axis: nothing tells how it will stick when it turns
// back. The stiffness of the last tick that had one is taken then, with no way to go in the direction of sliding, and
// back as far as the laws bear the other way.
//
// Where the base's way adds to its force, A has less axial stiffness, by what moving_stiffness.h finds that only a
// tick's haste gives it. Where the force falls A is the tick's own, until nothing is felt any more: the force may fall
// too soon, never too late.
//
// F is what the hand would feel of this needle at this coupling. An elastic tissue is answered exactly, however old the
// message is: delay enters with what the tissue did since, and with A's error.
//
// Where the needle's base is to go, p, is found with the tick's own A, nothing taken off, wherever a law holds it. The
// next tick answers a place with all that a tick's haste gives; had p been found with less, it would go too far there
// and back again, from message to message.
#pragma once

#include "client/haptics/local_model.h"

namespace acus::haptics {

class LocalResponse {
 public:
  // Nothing is felt, the proxy is where the device is.
  LocalResponse() = default;

  // Of a model, with coupling springs for translation (N/m, > 0) and rotation (N m/rad, > 0) at the base. `sticking` is
  // the axial stiffness of the last tick that had one (N/m, > 0), `moving` what a tick's has too much
  // (N/m, >= 0).
  LocalResponse(const LocalModel& model, double translation, double rotation, double sticking, double moving = 0);

  struct Answer {
    Wrench felt;  // N, N m, world, about the proxy
    Pose proxy;   // world, where the needle's base is to go
  };
  Answer operator()(const Pose& device);

  // The proxy was sent to this place after what the model knows of.
  void pass(const Pose& proxy);

  // What the springs of tissue and coupling hold while this wrench is felt (J), or while that of the tick is, if it is
  // more and `softest` is known: a force that falls too soon, as above, has not taken out what the surface still holds.
  // `softest` (N/m, 0: unknown) is the least stiffness that the surface has shown.
  double stored(const Wrench& felt, double softest = 0) const;

  // A spring that its force would deflect further than this is no spring but something that yields.
  static constexpr double kLongestSpring = 0.1;  // m
  // And no more than this of a spring's way counts as stored.
  static constexpr double kDeepest = 5e-3;  // m

 private:
  void let_stick(double sticking);
  void yield(double gone);
  void take_off(double moving);
  // F0 and A of a part of the axial way.
  struct Piece {
    const Matrix6& resisting;
    Vector6 force;
  };
  Vector6 felt(const Piece& piece, const Vector6& delta, Vector6& seen) const;
  double energy(const Vector6& force, double softest) const;
  Vector6 solve_free(const Piece& piece, const Vector6& delta) const;
  Vector6 solve_clamped(const Piece& piece, const Vector6& delta, double axial) const;

  bool empty_ = true;
  LocalModel model_;
  Quaternion world_from_base_;
  Vector6 coupling_;   // Kc, base frame
  Matrix6 resisting_;  // A, base frame
  Matrix6 loading_;    // the same where the force grows
  Vector6 force_;      // F0, base frame
  double anchor_ = 0;  // a, m
};

}  // namespace acus::haptics
