// SPDX-License-Identifier: MIT
// What is drawn over the bodies: arrows of forces, marks of events that stay, and the paths that needles have cut.
import {
  ArrowHelper, BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Group, LineBasicMaterial, LineSegments, Points,
  PointsMaterial, Vector3,
} from "./vendor/libraries.js";
import { float32, int32, type Event, type TissueShape } from "./messages.js";

export const eventColours: Record<string, number> = {
  contact: 0x9aa5b1, release: 0x9aa5b1, puncture: 0xd7263d, crossing: 0xf08a24, reentry: 0xb07aa1, exit: 0x2a9d5c,
  withdrawal: 0x2a6fdb, intrusion: 0xd7263d, tear: 0xd7263d, hub: 0x2a6fdb, slip: 0x9aa5b1,
};

const kMostEvents = 256, kMostPathPoints = 16384;
const dynamic = (numbers: number): BufferAttribute => {
  const attribute = new BufferAttribute(new Float32Array(numbers), 3);
  attribute.setUsage(DynamicDrawUsage);
  return attribute;
};

export class Marks {
  readonly group = new Group();
  private arrows = new Map<string, ArrowHelper>();
  private eventPlaces = dynamic(3 * kMostEvents);
  private eventPaint = dynamic(3 * kMostEvents);
  private events: Points;
  private count = 0;
  private pathPoints = dynamic(3 * kMostPathPoints);
  private paths: LineSegments;

  constructor() {
    const places = new BufferGeometry();
    places.setAttribute("position", this.eventPlaces);
    places.setAttribute("color", this.eventPaint);
    places.setDrawRange(0, 0);
    this.events = new Points(places, new PointsMaterial({ size: 7, sizeAttenuation: false, vertexColors: true, depthTest: false }));
    const lines = new BufferGeometry();
    lines.setAttribute("position", this.pathPoints);
    lines.setDrawRange(0, 0);
    this.paths = new LineSegments(lines, new LineBasicMaterial({ color: 0x7a1f3d, depthTest: false }));
    for (const object of [this.events, this.paths]) {
      object.frustumCulled = false;
      object.renderOrder = 3;
      this.group.add(object);
    }
  }

  clear(): void {
    this.count = 0;
    this.events.geometry.setDrawRange(0, 0);
    this.paths.geometry.setDrawRange(0, 0);
    for (const arrow of this.arrows.values()) this.group.remove(arrow);
    this.arrows.clear();
  }

  // `length` of an arrow per newton, in metres; none below a hundredth of a newton.
  arrow(name: string, from: Vector3, force: Vector3, length: number, colour: number): void {
    let arrow = this.arrows.get(name);
    if (!arrow) {
      arrow = new ArrowHelper(new Vector3(1, 0, 0), from, 0.01, colour);
      this.arrows.set(name, arrow);
      this.group.add(arrow);
    }
    const size = force.length();
    arrow.visible = size > 0.01;
    if (!arrow.visible) return;
    arrow.position.copy(from);
    arrow.setDirection(force.clone().normalize());
    const long = size * length;
    arrow.setLength(long, Math.min(0.3 * long, 0.12 * length), Math.min(0.15 * long, 0.06 * length));
  }

  event(event: Event): void {
    const at = this.count++ % kMostEvents;
    const colour = new Color(eventColours[event.kind] ?? 0x9aa5b1);
    this.eventPlaces.setXYZ(at, ...event.position);
    this.eventPaint.setXYZ(at, colour.r, colour.g, colour.b);
    this.eventPlaces.needsUpdate = this.eventPaint.needsUpdate = true;
    this.events.geometry.setDrawRange(0, Math.min(this.count, kMostEvents));
  }

  path(state: TissueShape): void {
    const points = float32(state.path_points);
    let vertex = 0, first = 0;
    for (const size of int32(state.path_sizes)) {
      for (let i = first; i + 1 < first + size && vertex + 2 <= kMostPathPoints; ++i)
        for (const p of [i, i + 1]) this.pathPoints.setXYZ(vertex++, points[3 * p]!, points[3 * p + 1]!, points[3 * p + 2]!);
      first += size;
    }
    this.pathPoints.needsUpdate = true;
    this.paths.geometry.setDrawRange(0, vertex);
  }
}
