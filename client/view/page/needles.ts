// SPDX-License-Identifier: MIT
// Needles as tubes of their true diameter, with a stripe that shows the spin, a bevel that points to where it steers,
// and a hub at the base, in its true diameter where it has one; guides as rings.
import {
  BufferAttribute, BufferGeometry, CylinderGeometry, DynamicDrawUsage, Group, Mesh, MeshPhongMaterial, Quaternion,
  SphereGeometry, TorusGeometry, Vector3, DoubleSide, Color,
} from "./vendor/libraries.js";
import type { HelloReply } from "./messages.js";

const kAround = 12; // corners of a section
const kPoint = 5; // radii, length of the point
const steel = new Color(0x8c97a4), stripe = new Color(0xd7263d);

export class NeedleTube {
  readonly group = new Group();
  readonly name: string;
  readonly nodes: number;
  positions: Float64Array;
  private radius: number;
  private apex = new Vector3(); // of the point, off the tip's axis (m), in its frame
  private tube: Mesh;
  private hub: Mesh;
  private hubRadius: number; // 0: a mark alone

  constructor(needle: HelloReply["needles"][number]) {
    this.name = needle.name;
    this.nodes = needle.nodes;
    this.radius = needle.diameter / 2;
    const [, y, z] = needle.cutting_direction;
    this.apex.set(0, y, z).setLength(Math.hypot(y, z) > 1e-6 ? this.radius : 0);
    this.positions = new Float64Array(3 * needle.nodes);
    const corners = (needle.nodes + 1) * (kAround + 1); // one ring more: the point
    const geometry = new BufferGeometry();
    for (const name of ["position", "normal", "color"]) {
      const attribute = new BufferAttribute(new Float32Array(3 * corners), 3);
      attribute.setUsage(DynamicDrawUsage);
      geometry.setAttribute(name, attribute);
    }
    const index: number[] = [];
    for (let i = 0; i < needle.nodes; ++i)
      for (let k = 0; k < kAround; ++k) {
        const a = i * (kAround + 1) + k, b = a + kAround + 1;
        index.push(a, b, a + 1, a + 1, b, b + 1);
      }
    geometry.setIndex(index);
    const colours = geometry.getAttribute("color");
    for (let i = 0; i < corners; ++i) {
      const colour = i % (kAround + 1) < 2 ? stripe : steel;
      colours.setXYZ(i, colour.r, colour.g, colour.b);
    }
    this.tube = new Mesh(geometry, new MeshPhongMaterial({ vertexColors: true, side: DoubleSide, shininess: 60 }));
    this.tube.frustumCulled = false;
    this.tube.renderOrder = 1;
    this.hubRadius = (needle.hub_diameter ?? 0) / 2;
    this.hub = new Mesh(this.hubRadius > 0 ? hubGeometry(this.hubRadius) : new SphereGeometry(1, 20, 14),
                        new MeshPhongMaterial({ color: 0x3b7dd8 }));
    this.group.add(this.tube, this.hub);
    const axis = new Vector3(1, 0, 0).applyQuaternion(quaternion(needle.base_orientation));
    const rest = new Float64Array(3 * needle.nodes), turns = new Float64Array(4 * needle.nodes);
    for (let i = 0; i < needle.nodes; ++i) {
      const p = axis.clone().multiplyScalar((needle.length * i) / (needle.nodes - 1));
      for (let k = 0; k < 3; ++k) rest[3 * i + k] = needle.base_position[k]! + p.getComponent(k);
      turns.set(needle.base_orientation, 4 * i);
    }
    this.update(rest, turns);
  }

  set held(held: boolean) {
    (this.hub.material as MeshPhongMaterial).color.set(held ? 0xf08a24 : 0x3b7dd8);
  }

  point(node: number): Vector3 {
    return new Vector3(this.positions[3 * node], this.positions[3 * node + 1], this.positions[3 * node + 2]);
  }

  dispose(): void {
    this.tube.geometry.dispose();
    this.hub.geometry.dispose();
  }

  // Of a `needle` state: world positions, and quaternions w x y z, of its nodes.
  update(positions: Float64Array, orientations: Float64Array): void {
    if (positions.length !== 3 * this.nodes || orientations.length !== 4 * this.nodes) return;
    this.positions = positions;
    const place = this.tube.geometry.getAttribute("position"), normal = this.tube.geometry.getAttribute("normal");
    const turn = new Quaternion(), across = new Vector3(), middle = new Vector3();
    for (let ring = 0; ring <= this.nodes; ++ring) {
      const i = Math.min(ring, this.nodes - 1);
      turn.set(orientations[4 * i + 1]!, orientations[4 * i + 2]!, orientations[4 * i + 3]!, orientations[4 * i]!);
      middle.copy(this.point(i));
      // The point: the last section drawn out of the one before it.
      const radius = ring === this.nodes ? 0 : this.radius;
      if (ring === this.nodes - 1) middle.addScaledVector(across.set(-1, 0, 0).applyQuaternion(turn), kPoint * this.radius);
      if (ring === this.nodes) middle.add(across.copy(this.apex).applyQuaternion(turn));
      for (let k = 0; k <= kAround; ++k) {
        const angle = (2 * Math.PI * k) / kAround;
        across.set(0, Math.cos(angle), Math.sin(angle)).applyQuaternion(turn);
        const corner = ring * (kAround + 1) + k;
        place.setXYZ(corner, middle.x + radius * across.x, middle.y + radius * across.y, middle.z + radius * across.z);
        normal.setXYZ(corner, across.x, across.y, across.z);
      }
    }
    place.needsUpdate = normal.needsUpdate = true;
    this.hub.position.copy(this.point(0));
    if (this.hubRadius > 0) this.hub.quaternion.copy(quaternion(Array.from(orientations.subarray(0, 4))));
    else this.hub.scale.setScalar(Math.max(2.2 * this.radius, 0.0025));
  }
}

// Behind the origin, its face across +x.
function hubGeometry(radius: number): BufferGeometry {
  const length = Math.max(3 * radius, 0.008);
  return new CylinderGeometry(radius, radius, length, 32).rotateZ(-Math.PI / 2).translate(-length / 2, 0, 0);
}

export const quaternion = (q: readonly number[]): Quaternion => new Quaternion(q[1], q[2], q[3], q[0]);

export function guideRing(guide: HelloReply["guides"][number], radius: number): Mesh {
  const ring = new Mesh(new TorusGeometry(Math.max(2.5 * radius, 0.003), Math.max(radius, 0.001), 10, 28),
                        new MeshPhongMaterial({ color: 0x6b7280 }));
  ring.position.set(...guide.position);
  ring.quaternion.copy(quaternion(guide.orientation)).multiply(new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), Math.PI / 2));
  return ring;
}
