// SPDX-License-Identifier: MIT
// The tissue: its surface, translucent, in the colours of its regions, and a cut through the inside along a needle.
// All buffers have their size from the start and are written in place.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, DynamicDrawUsage, Group, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, Vector3,
} from "./vendor/libraries.js";
import { float32, int32, type DescribeReply } from "./messages.js";
import { Strain } from "./strain.js";

// Distinct also for those who do not tell red from green.
const palette = [0xd98c6a, 0xe8c15a, 0x6f9fc8, 0xb07aa1, 0x7fb08a, 0xc9635d, 0x9aa5b1, 0x5b8f8f];
export const regionColour = (region: number): number => palette[region % palette.length] as number;

// From none to the most: dark blue, green, yellow.
export const scale = (share: number): Color =>
  new Color().setHSL(0.66 - 0.52 * Math.min(Math.max(share, 0), 1), 0.75, 0.4 + 0.15 * share);

const dynamic = (array: Float32Array, items: number): BufferAttribute => {
  const attribute = new BufferAttribute(array, items);
  attribute.setUsage(DynamicDrawUsage);
  return attribute;
};

export class Tissue {
  readonly group = new Group();
  readonly regions: string[];
  readonly low = new Vector3(Infinity, Infinity, Infinity);
  readonly high = new Vector3(-Infinity, -Infinity, -Infinity);
  colouring: "regions" | "displacement" | "strain" = "regions";
  largest = 0; // of what colours it: m of displacement, or strain
  private rest: Float32Array;
  private tetrahedra: Int32Array;
  private regionOf: Int32Array;
  private positions: BufferAttribute;
  private colours: BufferAttribute;
  private skin: Mesh[] = [];
  private cut: Mesh;
  private cutPositions: BufferAttribute;
  private cutColours: BufferAttribute;
  private side: Float32Array;
  private strain: Strain | null = null;

  constructor(private description: DescribeReply) {
    this.regions = description.regions;
    this.rest = float32(description.positions);
    this.tetrahedra = int32(description.tetrahedra);
    this.regionOf = int32(description.tetrahedron_regions);
    this.positions = dynamic(this.rest.slice(), 3);
    this.colours = dynamic(new Float32Array(this.rest.length), 3);
    this.side = new Float32Array(this.rest.length / 3);
    for (let i = 0; i < this.rest.length; i += 3) {
      const p = new Vector3(this.rest[i], this.rest[i + 1], this.rest[i + 2]);
      this.low.min(p);
      this.high.max(p);
    }
    this.makeSkin(int32(description.triangles));
    const most = 6 * this.regionOf.length; // two triangles of each tetrahedron at most
    this.cutPositions = dynamic(new Float32Array(3 * most), 3);
    this.cutColours = dynamic(new Float32Array(3 * most), 3);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.cutPositions);
    geometry.setAttribute("color", this.cutColours);
    this.cut = new Mesh(geometry, new MeshBasicMaterial({ vertexColors: true, side: DoubleSide }));
    this.cut.frustumCulled = false;
    this.group.add(this.cut);
    this.paint();
  }

  // Whether another description is of the same tissue.
  is(other: DescribeReply): boolean {
    const same = (a: Uint8Array, b: Uint8Array): boolean => a.length === b.length && a.every((byte, i) => byte === b[i]);
    return same(this.description.positions, other.positions) && same(this.description.tetrahedra, other.tetrahedra) &&
      same(this.description.tetrahedron_regions, other.tetrahedron_regions) && String(this.regions) === String(other.regions);
  }

  colourBy(colouring: Tissue["colouring"]): void {
    if (colouring === this.colouring) return;
    this.colouring = colouring;
    this.paint();
  }

  set skinVisible(visible: boolean) {
    for (const mesh of this.skin) mesh.visible = visible;
  }
  set cutVisible(visible: boolean) {
    this.cut.visible = visible;
  }

  dispose(): void {
    for (const mesh of [...this.skin, this.cut]) mesh.geometry.dispose();
  }

  // Of a `tissue` state.
  update(positions: Float32Array): void {
    if (positions.length !== this.rest.length) return;
    (this.positions.array as Float32Array).set(positions);
    this.positions.needsUpdate = true;
    this.paint();
  }

  // The cut by the plane through `point`, across `normal`: the inside that is seen if what is before it is taken away.
  slice(point: Vector3, normal: Vector3): void {
    if (!this.cut.visible) return;
    const x = this.positions.array as Float32Array, side = this.side, out = this.cutPositions.array as Float32Array;
    const paint = this.cutColours.array as Float32Array, shade = this.colours.array as Float32Array;
    const offset = point.dot(normal);
    for (let i = 0; i < side.length; ++i)
      side[i] = x[3 * i]! * normal.x + x[3 * i + 1]! * normal.y + x[3 * i + 2]! * normal.z - offset;
    let vertex = 0;
    const put = (a: number, b: number, colour: Color): void => {
      const share = side[a]! / (side[a]! - side[b]!);
      for (let k = 0; k < 3; ++k) {
        out[3 * vertex + k] = x[3 * a + k]! + share * (x[3 * b + k]! - x[3 * a + k]!);
        const own = k === 0 ? colour.r : k === 1 ? colour.g : colour.b;
        paint[3 * vertex + k] = this.colouring !== "regions"
          ? shade[3 * a + k]! + share * (shade[3 * b + k]! - shade[3 * a + k]!)
          : own;
      }
      ++vertex;
    };
    const colours = this.regions.map((_, region) => new Color(regionColour(region)));
    const above: number[] = [], below: number[] = [];
    const most = this.cutPositions.count - 6;
    for (let t = 0; t < this.regionOf.length && vertex <= most; ++t) {
      above.length = below.length = 0;
      for (let k = 0; k < 4; ++k) {
        const node = this.tetrahedra[4 * t + k]!;
        (side[node]! >= 0 ? above : below).push(node);
      }
      if (above.length === 0 || below.length === 0) continue;
      const colour = colours[this.regionOf[t]!]!;
      const [few, many] = above.length <= below.length ? [above, below] : [below, above];
      if (few.length === 1) {
        for (const other of many) put(few[0]!, other, colour);
      } else {
        const corners: [number, number][] = [[few[0]!, many[0]!], [few[0]!, many[1]!], [few[1]!, many[1]!], [few[1]!, many[0]!]];
        for (const corner of [0, 1, 2, 0, 2, 3]) put(corners[corner]![0], corners[corner]![1], colour);
      }
    }
    this.cut.geometry.setDrawRange(0, vertex);
    this.cutPositions.needsUpdate = this.cutColours.needsUpdate = true;
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
      geometry.setIndex(list);
      const material = new MeshLambertMaterial({
        color: regionColour(region), flatShading: true, transparent: true, opacity: 0.32, side: DoubleSide, depthWrite: false,
      });
      const mesh = new Mesh(geometry, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = 2;
      this.skin.push(mesh);
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
    const x = this.positions.array as Float32Array, colours = this.colours.array as Float32Array;
    const byRegion = this.colouring === "regions";
    for (const [region, mesh] of this.skin.entries()) {
      const material = mesh.material as MeshLambertMaterial;
      if (material.vertexColors !== byRegion) continue;
      material.vertexColors = !byRegion;
      material.color.set(byRegion ? regionColour(region) : 0xffffff);
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
