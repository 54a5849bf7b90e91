// SPDX-License-Identifier: MIT
// What the mesh is too coarse to show around needles: dents displace its points (protocol/README.md, "tissue"). Triangles
// near them are drawn in pieces small enough to show them, with a corner where a centre is: a tip lies on the skin.
import { float32, type TissueShape } from "./messages.js";

// A corner of a triangle: place on the mesh (m), and colour.
export type Corner = [number, number, number, number, number, number];
// Takes corners three by three, placed where the tissue is; false: there is no more room.
export type Take = (corner: Corner) => boolean;

const finest = 0.5; // longest edge of a piece, as a share of its distance from a dent's centre, or of r
const shortest = 5e-5; // m, of an edge that is halved
const beside = 0.3; // how far a triangle reaches from one of its edges, as a share of that
const apart = 0.1; // of a centre from a triangle's plane, at most, and from its corners, at least, as a share of r
const seen = 5e-5; // m, displacement from which on edges are halved

const reach = 8; // in R: beyond it a dent is left out, as the server does

export class Dents {
  private dents: { x: number; y: number; z: number; move: [number, number, number]; moves: number; r: number; R: number; whole: number }[] = [];

  constructor(state?: TissueShape) {
    const numbers = (packed?: Uint8Array): Float32Array => (packed ? float32(packed) : new Float32Array());
    const centres = numbers(state?.dent_centres), moves = numbers(state?.dent_moves), radii = numbers(state?.dent_radii);
    for (let i = 0; 2 * i < radii.length; ++i) {
      const [r, R] = [radii[2 * i]!, radii[2 * i + 1]!];
      const move: [number, number, number] = [moves[3 * i]!, moves[3 * i + 1]!, moves[3 * i + 2]!];
      if (!(R > r && r > 0)) continue;
      this.dents.push({ x: centres[3 * i]!, y: centres[3 * i + 1]!, z: centres[3 * i + 2]!, move, moves: Math.hypot(...move), r, R,
                        whole: (r * R) / (R - r) });
    }
  }

  get any(): boolean {
    return this.dents.length > 0;
  }

  // Writes to `out`, from its place `at` on, where the mesh's point (x, y, z) really is.
  place(x: number, y: number, z: number, out: Float32Array, at: number): void {
    out[at] = x;
    out[at + 1] = y;
    out[at + 2] = z;
    for (const dent of this.dents) {
      const square = (x - dent.x) ** 2 + (y - dent.y) ** 2 + (z - dent.z) ** 2;
      if (square > (reach * dent.R) ** 2) continue;
      const share = shareOf(dent, square);
      for (let k = 0; k < 3; ++k) out[at + k]! += share * dent.move[k]!;
    }
  }

  // Whether a triangle near these nodes (places in x) may have to be drawn in pieces.
  mayNeedPieces(x: Float32Array, a: number, b: number, c: number): boolean {
    for (const dent of this.dents) {
      let nearest = Infinity, longest = 0;
      for (const [p, q] of [[a, b], [b, c], [c, a]] as const) {
        nearest = Math.min(nearest, (x[p]! - dent.x) ** 2 + (x[p + 1]! - dent.y) ** 2 + (x[p + 2]! - dent.z) ** 2);
        longest = Math.max(longest, (x[p]! - x[q]!) ** 2 + (x[p + 1]! - x[q + 1]!) ** 2 + (x[p + 2]! - x[q + 2]!) ** 2);
      }
      const near = Math.max(0, Math.sqrt(nearest) - Math.sqrt(longest));
      if (shareOf(dent, near * near) * dent.moves > seen) return true;
    }
    return false;
  }

  // The pieces of a triangle. An edge is halved by its ends alone, so neighbours fit. False: there is no more room.
  pieces(a: Corner, b: Corner, c: Corner, take: Take): boolean {
    return this.piecesOf(a, b, c, this.middle(a, b), this.middle(b, c), this.middle(c, a), take);
  }

  private piecesOf(a: Corner, b: Corner, c: Corner, ab: Corner | null, bc: Corner | null, ca: Corner | null, take: Take): boolean {
    if (!ab && !bc && !ca) {
      const centre = this.centreIn(a, b, c);
      if (centre) return this.pieces(a, b, centre, take) && this.pieces(b, c, centre, take) && this.pieces(c, a, centre, take);
      return take(a) && take(b) && take(c);
    }
    if (ab && bc && ca)
      return this.pieces(a, ab, ca, take) && this.pieces(ab, b, bc, take) && this.pieces(ca, bc, c, take) && this.pieces(ab, bc, ca, take);
    if (ab && bc) return this.pieces(ab, b, bc, take) && this.pieces(a, ab, bc, take) && this.pieces(a, bc, c, take);
    if (ab && !ca) return this.pieces(a, ab, c, take) && this.pieces(ab, b, c, take);
    return this.piecesOf(b, c, a, bc, ca, ab, take); // turned until the first edge is halved, and of two the second
  }

  // Where a dent's centre lies within a triangle, away from its corners.
  private centreIn(a: Corner, b: Corner, c: Corner): Corner | null {
    const ab = minus(b, a), ac = minus(c, a), normal = cross(ab, ac), square = dot(normal, normal);
    if (square === 0) return null;
    for (const dent of this.dents) {
      if (dent.moves <= seen) continue;
      const way: Vector = [dent.x - a[0], dent.y - a[1], dent.z - a[2]], height = dot(way, normal);
      const ofB = dot(cross(way, ac), normal) / square, ofC = dot(cross(ab, way), normal) / square, ofA = 1 - ofB - ofC;
      if (!(ofA > 0 && ofB > 0 && ofC > 0) || height ** 2 > (apart * dent.r) ** 2 * square) continue;
      const place = a.map((number, k) => ofA * number + ofB * b[k]! + ofC * c[k]!) as Corner;
      if ([a, b, c].every((corner) => Math.hypot(...minus(corner, place)) > apart * dent.r)) return place;
    }
    return null;
  }

  private middle(a: Corner, b: Corner): Corner | null {
    const long = before(a, b) ? this.tooLong(a, b) : this.tooLong(b, a); // the same from either side
    return long ? (a.map((number, k) => (number + b[k]!) / 2) as Corner) : null;
  }

  private tooLong(a: Corner, b: Corner): boolean {
    const x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2], square = x * x + y * y + z * z;
    if (square < shortest * shortest) return false;
    for (const dent of this.dents) {
      const cx = dent.x - a[0], cy = dent.y - a[1], cz = dent.z - a[2];
      const along = Math.min(Math.max((cx * x + cy * y + cz * z) / square, 0), 1);
      const nearest = (cx - along * x) ** 2 + (cy - along * y) ** 2 + (cz - along * z) ** 2;
      if (square <= finest * finest * (nearest + dent.r * dent.r)) continue;
      const triangle = Math.max(0, Math.sqrt(nearest) - beside * Math.sqrt(square));
      if (shareOf(dent, triangle * triangle) * dent.moves > seen) return true;
    }
    return false;
  }
}

const shareOf = (dent: { r: number; R: number; whole: number }, square: number): number =>
  (1 / Math.sqrt(square + dent.r * dent.r) - 1 / Math.sqrt(square + dent.R * dent.R)) * dent.whole;

type Vector = [number, number, number];
const minus = (a: Corner, b: Corner): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vector, b: Vector): Vector =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

const before = (a: Corner, b: Corner): boolean =>
  a[0] !== b[0] ? a[0] < b[0] : a[1] !== b[1] ? a[1] < b[1] : a[2] < b[2];
