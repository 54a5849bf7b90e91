// SPDX-License-Identifier: MIT
// The tissue: its surface, translucent, in the colours of its regions, and a cut through the inside along a needle.
// All buffers have their size from the start and are written in place.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, DynamicDrawUsage, Group, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, Vector3,
} from "./vendor/libraries.js";
import { Dents, type Corner } from "./dents.js";
import { float32, int32, type DescribeReply, type TissueShape } from "./messages.js";
import { Strain } from "./strain.js";

// Distinct also for those who do not tell red from green.
const palette = [0xd98c6a, 0xe8c15a, 0x6f9fc8, 0xb07aa1, 0x7fb08a, 0xc9635d, 0x9aa5b1, 0x5b8f8f];
// Of tissues that people know by their colour, by words in their names.
const known: [RegExp, number][] = [
  [/bone|rib|skull|vertebra|spine|pelvis|femur|tooth/i, 0xf0e6cc], [/vein|cava/i, 0x5572b8],
  [/vessel|arter|aorta|blood/i, 0xc23b3b], [/fat\b|adipose/i, 0xf0c95a], [/skin|dermis/i, 0xe3ab8a],
  [/muscle/i, 0xa8504a], [/liver/i, 0x9a5548], [/kidney/i, 0xa65f55], [/prostate/i, 0xc98a9a], [/brain|cortex/i, 0xd9a7b3],
  [/tumou?r|lesion|metasta|cyst/i, 0x7a4fa0], [/lung/i, 0xe7a0a0], [/nerve/i, 0xe6d24a], [/gel|phantom/i, 0x8fb8cc],
];

// What the scene gives, else what the names say, else one of the palette that is not taken yet.
export function regionColours(names: string[], given: string[] = []): number[] {
  const colours = names.map((name, i) => {
    if (given[i]) return parseInt(given[i]!.slice(1), 16);
    return known.find(([words]) => words.test(name))?.[1];
  });
  const taken = new Set(colours);
  const free = palette.filter((colour) => !taken.has(colour));
  let next = 0;
  return colours.map((colour) => colour ?? (free.length ? free[next++ % free.length]! : palette[next++ % palette.length]!));
}

// From none to the most: dark blue, green, yellow.
export const scale = (share: number): Color =>
  new Color().setHSL(0.66 - 0.52 * Math.min(Math.max(share, 0), 1), 0.75, 0.4 + 0.15 * share);

// Corners of the pieces of triangles near dents, at most; beyond that triangles are drawn whole.
const mostCorners = 3 * 16384;

// Triangles with places and colours, those near dents in pieces.
class Pieces {
  readonly geometry = new BufferGeometry();
  private places: BufferAttribute;
  private paint: BufferAttribute;
  private corners = 0;
  private divided = 0; // of them, of triangles in pieces
  private shown = 0;

  // With room for so many corners of whole triangles besides.
  constructor(wholes = 0) {
    const most = wholes + mostCorners;
    this.places = dynamic(new Float32Array(3 * most), 3);
    this.paint = dynamic(new Float32Array(3 * most), 3);
    this.geometry.setAttribute("position", this.places);
    this.geometry.setAttribute("color", this.paint);
    this.geometry.setDrawRange(0, 0);
  }

  clear(): void {
    this.corners = this.divided = 0;
  }
  // False, and nothing is added, if there is no room for its pieces.
  divide(dents: Dents, a: Corner, b: Corner, c: Corner): boolean {
    const before = this.corners;
    const all = dents.pieces(a, b, c, (corner) => {
      if (this.corners - before >= 3 && this.divided + this.corners - before >= mostCorners) return false;
      this.put(dents, corner);
      return true;
    });
    if (!all) this.corners = before;
    else if (this.corners - before > 3) this.divided += this.corners - before;
    return all;
  }
  // In pieces, or whole if there is no room for those.
  add(dents: Dents, a: Corner, b: Corner, c: Corner): void {
    if (dents.any && this.divide(dents, a, b, c)) return;
    for (const corner of [a, b, c]) this.put(dents, corner);
  }
  show(): void {
    if (this.corners === 0 && this.shown === 0) return;
    this.geometry.setDrawRange(0, (this.shown = this.corners));
    this.places.needsUpdate = this.paint.needsUpdate = true;
  }

  private put(dents: Dents, corner: Corner): void {
    const places = this.places.array as Float32Array, paint = this.paint.array as Float32Array, at = 3 * this.corners++;
    dents.place(corner[0], corner[1], corner[2], places, at);
    for (let k = 0; k < 3; ++k) paint[at + k] = corner[3 + k]!;
  }
}

const dynamic = (array: Float32Array, items: number): BufferAttribute => {
  const attribute = new BufferAttribute(array, items);
  attribute.setUsage(DynamicDrawUsage);
  return attribute;
};

export class Tissue {
  readonly group = new Group();
  readonly regions: string[];
  readonly shades: number[]; // of the regions
  readonly low = new Vector3(Infinity, Infinity, Infinity);
  readonly high = new Vector3(-Infinity, -Infinity, -Infinity);
  colouring: "regions" | "displacement" | "strain" = "regions";
  largest = 0; // of what colours it: m of displacement, or strain
  private rest: Float32Array;
  private tetrahedra: Int32Array;
  private regionOf: Int32Array;
  private x: Float32Array; // of the mesh's nodes
  private dents = new Dents();
  private positions: BufferAttribute; // where the nodes really are
  private colours: BufferAttribute;
  private skin: Mesh[] = [];
  private whole: Uint32Array[] = []; // of each mesh in `skin`, its triangles,
  private pieces: Pieces[] = []; // and those that are drawn in pieces
  private divided = false;
  private cut: Mesh;
  private cutPieces: Pieces;
  private side: Float32Array;
  private strain: Strain | null = null;

  constructor(private description: DescribeReply) {
    this.regions = description.regions;
    this.shades = regionColours(this.regions, description.region_colours);
    this.rest = float32(description.positions);
    this.tetrahedra = int32(description.tetrahedra);
    this.regionOf = int32(description.tetrahedron_regions);
    this.x = this.rest.slice();
    this.positions = dynamic(this.rest.slice(), 3);
    this.colours = dynamic(new Float32Array(this.rest.length), 3);
    this.side = new Float32Array(this.rest.length / 3);
    for (let i = 0; i < this.rest.length; i += 3) {
      const p = new Vector3(this.rest[i], this.rest[i + 1], this.rest[i + 2]);
      this.low.min(p);
      this.high.max(p);
    }
    this.makeSkin(int32(description.triangles));
    this.cutPieces = new Pieces(6 * this.regionOf.length); // two triangles of each tetrahedron at most
    this.cut = new Mesh(this.cutPieces.geometry, new MeshBasicMaterial({ vertexColors: true, side: DoubleSide }));
    this.cut.frustumCulled = false;
    this.group.add(this.cut);
    this.paint();
  }

  // Whether another description is of the same tissue.
  is(other: DescribeReply): boolean {
    const same = (a: Uint8Array, b: Uint8Array): boolean => a.length === b.length && a.every((byte, i) => byte === b[i]);
    return same(this.description.positions, other.positions) && same(this.description.tetrahedra, other.tetrahedra) &&
      same(this.description.tetrahedron_regions, other.tetrahedron_regions) && String(this.regions) === String(other.regions) &&
      String(this.description.region_colours) === String(other.region_colours);
  }

  colourBy(colouring: Tissue["colouring"]): void {
    if (colouring === this.colouring) return;
    this.colouring = colouring;
    this.paint();
    this.divideSkin();
  }

  set skinVisible(visible: boolean) {
    for (const mesh of this.skin) mesh.visible = visible;
  }
  set cutVisible(visible: boolean) {
    this.cut.visible = visible;
  }

  dispose(): void {
    for (const { geometry } of [...this.skin, ...this.pieces, this.cut]) geometry.dispose();
  }

  // Of a `tissue` state.
  update(state: TissueShape): void {
    const x = float32(state.positions);
    if (x.length !== this.rest.length) return;
    this.x = x;
    this.dents = new Dents(state);
    const places = this.positions.array as Float32Array;
    for (let i = 0; i < x.length; i += 3) this.dents.place(x[i]!, x[i + 1]!, x[i + 2]!, places, i);
    this.positions.needsUpdate = true;
    this.paint();
    this.divideSkin();
  }

  // The cut by the plane through `point`, across `normal`: the inside that is seen if what is before it is taken away.
  slice(point: Vector3, normal: Vector3): void {
    if (!this.cut.visible) return;
    const x = this.x, side = this.side;
    const offset = point.dot(normal);
    for (let i = 0; i < side.length; ++i)
      side[i] = x[3 * i]! * normal.x + x[3 * i + 1]! * normal.y + x[3 * i + 2]! * normal.z - offset;
    const colours = this.shades.map((shade) => new Color(shade));
    const between = (a: number, b: number, colour: Color): Corner => {
      const share = side[a]! / (side[a]! - side[b]!);
      const from = this.corner(a, colour), to = this.corner(b, colour);
      return from.map((number, k) => number + share * (to[k]! - number)) as Corner;
    };
    const above: number[] = [], below: number[] = [];
    this.cutPieces.clear();
    for (let t = 0; t < this.regionOf.length; ++t) {
      above.length = below.length = 0;
      for (let k = 0; k < 4; ++k) {
        const node = this.tetrahedra[4 * t + k]!;
        (side[node]! >= 0 ? above : below).push(node);
      }
      if (above.length === 0 || below.length === 0) continue;
      const colour = colours[this.regionOf[t]!]!;
      const [few, many] = above.length <= below.length ? [above, below] : [below, above];
      const ends: [number, number][] = few.length === 1
        ? many.map((other) => [few[0]!, other])
        : [[few[0]!, many[0]!], [few[0]!, many[1]!], [few[1]!, many[1]!], [few[1]!, many[0]!]];
      const corners = ends.map(([from, to]) => between(from, to, colour));
      for (let k = 2; k < corners.length; ++k) this.cutPieces.add(this.dents, corners[0]!, corners[k - 1]!, corners[k]!);
    }
    this.cutPieces.show();
  }

  // A node of the mesh, in its colour or in that of its region.
  private corner(node: number, region: Color): Corner {
    const x = this.x, shade = this.colours.array as Float32Array, at = 3 * node;
    return this.colouring === "regions"
      ? [x[at]!, x[at + 1]!, x[at + 2]!, region.r, region.g, region.b]
      : [x[at]!, x[at + 1]!, x[at + 2]!, shade[at]!, shade[at + 1]!, shade[at + 2]!];
  }

  // Triangles near dents leave the meshes of their regions and are drawn in pieces. One that there is no room for stays
  // whole, and need not fit its neighbours.
  private divideSkin(): void {
    if (!this.dents.any && !this.divided) return;
    this.divided = this.dents.any;
    const white = new Color(0xffffff); // the material has the region's colour
    this.skin.forEach((mesh, i) => {
      const whole = this.whole[i]!, pieces = this.pieces[i]!, index = mesh.geometry.getIndex()!;
      const shown = index.array as Uint32Array;
      let count = 0;
      pieces.clear();
      for (let t = 0; t < whole.length; t += 3) {
        const [a, b, c] = [whole[t]!, whole[t + 1]!, whole[t + 2]!];
        if (this.dents.mayNeedPieces(this.x, 3 * a, 3 * b, 3 * c) &&
            pieces.divide(this.dents, this.corner(a, white), this.corner(b, white), this.corner(c, white))) continue;
        shown[count++] = a;
        shown[count++] = b;
        shown[count++] = c;
      }
      mesh.geometry.setDrawRange(0, count);
      index.needsUpdate = true;
      pieces.show();
    });
  }

  // One mesh for each region, all with the same nodes.
  private makeSkin(triangles: Int32Array): void {
    const regions = this.faceRegions();
    const indices: number[][] = this.regions.map(() => []);
    for (let i = 0; i < triangles.length; i += 3) {
      const corners = [triangles[i]!, triangles[i + 1]!, triangles[i + 2]!];
      indices[regions.get(faceKey(corners)) ?? 0]?.push(...corners);
    }
    indices.forEach((list, region) => {
      if (list.length === 0) return;
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", this.positions);
      geometry.setAttribute("color", this.colours);
      const whole = new Uint32Array(list), index = new BufferAttribute(whole.slice(), 1);
      index.setUsage(DynamicDrawUsage);
      geometry.setIndex(index);
      const material = new MeshLambertMaterial({
        color: this.shades[region]!, flatShading: true, transparent: true, opacity: 0.32, side: DoubleSide, depthWrite: false,
      });
      const pieces = new Pieces();
      const mesh = new Mesh(geometry, material), fine = new Mesh(pieces.geometry, material);
      for (const each of [mesh, fine]) {
        each.frustumCulled = false;
        each.renderOrder = 2;
      }
      mesh.add(fine);
      this.skin.push(mesh);
      this.whole.push(whole);
      this.pieces.push(pieces);
      this.group.add(mesh);
    });
  }

  // Of every face of every tetrahedron; those inside are overwritten by a neighbour's, which does not matter.
  private faceRegions(): Map<string, number> {
    const regions = new Map<string, number>();
    const corner = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
    for (let t = 0; t < this.regionOf.length; ++t)
      for (const face of corner) regions.set(faceKey(face.map((k) => this.tetrahedra[4 * t + k]!)), this.regionOf[t]!);
    return regions;
  }

  private paint(): void {
    const x = this.x, colours = this.colours.array as Float32Array;
    const byRegion = this.colouring === "regions";
    for (const [region, mesh] of this.skin.entries()) {
      const material = mesh.material as MeshLambertMaterial;
      if (material.vertexColors !== byRegion) continue;
      material.vertexColors = !byRegion;
      material.color.set(byRegion ? this.shades[region]! : 0xffffff);
      material.needsUpdate = true;
    }
    if (byRegion) return;
    let value = (i: number): number =>
      Math.hypot(x[3 * i]! - this.rest[3 * i]!, x[3 * i + 1]! - this.rest[3 * i + 1]!, x[3 * i + 2]! - this.rest[3 * i + 2]!);
    if (this.colouring === "strain") {
      const strain = (this.strain ??= new Strain(this.rest, this.tetrahedra));
      strain.update(x);
      value = (i) => strain.ofNode[i]!;
    }
    this.largest = 0;
    for (let i = 0; 3 * i < x.length; ++i) this.largest = Math.max(this.largest, value(i));
    for (let i = 0; 3 * i < x.length; ++i) scale(value(i) / Math.max(this.largest, 1e-6)).toArray(colours, 3 * i);
    this.colours.needsUpdate = true;
  }
}

const faceKey = (corners: number[]): string => corners.slice().sort((a, b) => a - b).join(" ");
