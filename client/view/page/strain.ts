// SPDX-License-Identifier: MIT
// How much the tissue is distorted: the equivalent strain sqrt(2/3 e:e) of Green's tensor without its change of volume,
// e = dev (FᵀF − 1)/2, of each tetrahedron; at a node the mean of those around it.
export class Strain {
  readonly ofNode: Float32Array;
  private inverse: Float64Array; // 3 x 3 each, of the rest's edges
  private around: Float32Array; // tetrahedra of each node

  constructor(rest: Float32Array, private tetrahedra: Int32Array) {
    const count = tetrahedra.length / 4;
    this.ofNode = new Float32Array(rest.length / 3);
    this.around = new Float32Array(rest.length / 3);
    this.inverse = new Float64Array(9 * count);
    const edges = new Float64Array(9);
    for (const node of tetrahedra) this.around[node]! += 1;
    for (let t = 0; t < count; ++t) {
      this.edges(rest, t, edges);
      const [a, b, c, d, e, f, g, h, i] = edges as unknown as number[] as [number, number, number, number, number, number, number, number, number];
      const adjugate = [e * i - f * h, c * h - b * i, b * f - c * e, f * g - d * i, a * i - c * g, c * d - a * f,
                        d * h - e * g, b * g - a * h, a * e - b * d];
      const volume = a * adjugate[0]! + b * adjugate[3]! + c * adjugate[6]!;
      this.inverse.set(adjugate.map((each) => each / volume), 9 * t);
    }
  }

  // The three edges from the first corner, as columns.
  private edges(x: Float32Array, t: number, out: Float64Array): void {
    const first = 3 * this.tetrahedra[4 * t]!;
    for (let k = 0; k < 3; ++k) {
      const corner = 3 * this.tetrahedra[4 * t + k + 1]!;
      for (let row = 0; row < 3; ++row) out[3 * row + k] = x[corner + row]! - x[first + row]!;
    }
  }

  update(x: Float32Array): void {
    const edges = new Float64Array(9), f = new Float64Array(9);
    this.ofNode.fill(0);
    for (let t = 0; 4 * t < this.tetrahedra.length; ++t) {
      this.edges(x, t, edges);
      for (let row = 0; row < 3; ++row)
        for (let column = 0; column < 3; ++column) {
          let sum = 0;
          for (let k = 0; k < 3; ++k) sum += edges[3 * row + k]! * this.inverse[9 * t + 3 * k + column]!;
          f[3 * row + column] = sum;
        }
      const green = (i: number, j: number): number =>
        0.5 * (f[i]! * f[j]! + f[3 + i]! * f[3 + j]! + f[6 + i]! * f[6 + j]! - Number(i === j));
      const xx = green(0, 0), yy = green(1, 1), zz = green(2, 2), mean = (xx + yy + zz) / 3;
      const shear = green(0, 1) ** 2 + green(1, 2) ** 2 + green(0, 2) ** 2;
      const strain = Math.sqrt((2 / 3) * ((xx - mean) ** 2 + (yy - mean) ** 2 + (zz - mean) ** 2 + 2 * shear));
      for (let k = 0; k < 4; ++k) {
        const node = this.tetrahedra[4 * t + k]!;
        this.ofNode[node]! += strain / this.around[node]!;
      }
    }
  }
}
