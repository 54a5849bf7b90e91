// SPDX-License-Identifier: MIT
// The tips of acus-cloud's worlds: as points about each needle's tip, and of the chosen needle, seen along it, with a scale.
// Drawn is how far each is from the tip of the world in which nothing is changed, which may be a moment behind.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Group, Points, PointsMaterial, Vector3 } from "./vendor/libraries.js";
import { float64, type CloudOfTips } from "./messages.js";
import type { NeedleTube } from "./needles.js";
import { element, spot } from "./panel.js";

const kMostTips = 1000;
const kColour = 0x8e44ad;
const kHalf = 60; // units of the drawing from its middle to its side
const kLevels = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100]; // mm, of the ring

interface Tips { apart: Vector3[]; spread: number } // m

export class Cloud {
  readonly group = new Group();
  private tips = new Map<string, Tips>();
  private points = new Map<string, Points>();

  clear(): void {
    this.tips.clear();
    element("cloud").hidden = true;
    for (const each of this.points.values()) each.visible = false;
  }

  take(message: CloudOfTips): void {
    for (const needle of message.needles) {
      const numbers = float64(needle.tips), first = new Vector3(numbers[0], numbers[1], numbers[2]);
      const apart: Vector3[] = [];
      for (let i = 0; 3 * i + 2 < numbers.length && i < kMostTips; ++i)
        apart.push(new Vector3(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]).sub(first));
      this.tips.set(needle.name, { apart, spread: needle.spread });
    }
  }

  // About the tips of the needles as they are drawn.
  draw(needles: Map<string, NeedleTube>, chosen: string): void {
    for (const [name, { apart }] of this.tips) {
      const needle = needles.get(name);
      if (needle) this.place(name, apart, needle.point(needle.nodes - 1));
    }
    const tips = this.tips.get(chosen), needle = needles.get(chosen);
    element("cloud").hidden = !tips || !needle;
    if (tips && needle) this.show(tips, needle.point(needle.nodes - 1).sub(needle.point(needle.nodes - 2)).normalize());
  }

  private place(name: string, apart: Vector3[], tip: Vector3): void {
    let points = this.points.get(name);
    if (!points) {
      const places = new BufferAttribute(new Float32Array(3 * kMostTips), 3);
      places.setUsage(DynamicDrawUsage);
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", places);
      points = new Points(geometry, new PointsMaterial({ size: 5, sizeAttenuation: false, color: kColour, depthTest: false }));
      points.frustumCulled = false;
      points.renderOrder = 4;
      this.points.set(name, points);
      this.group.add(points);
    }
    const places = points.geometry.getAttribute("position");
    apart.forEach((each, i) => places.setXYZ(i, tip.x + each.x, tip.y + each.y, tip.z + each.z));
    places.needsUpdate = true;
    points.geometry.setDrawRange(0, apart.length);
    points.visible = true;
  }

  // Seen along the needle; up is the world's z, or where the needle points up or down, its y.
  private show({ apart, spread }: Tips, along: Vector3): void {
    const up = Math.abs(along.z) < 0.9 ? new Vector3(0, 0, 1) : new Vector3(0, 1, 0);
    const across = new Vector3().crossVectors(along, up).normalize(), above = new Vector3().crossVectors(across, along);
    const seen = apart.map((each) => [1e3 * each.dot(across), 1e3 * each.dot(above)] as const); // mm
    const largest = Math.max(...seen.map(([x, y]) => Math.hypot(x, y)));
    const ring = kLevels.find((level) => 1.5 * level >= largest) ?? kLevels[kLevels.length - 1]!;
    const scale = (0.6 * kHalf) / ring;
    const picture = element("tips");
    while (picture.childElementCount > 1 + apart.length) picture.lastElementChild!.remove();
    while (picture.childElementCount < 1 + apart.length) picture.append(mark("circle", { r: 2.5, fill: css }));
    place(picture.children[0]!, { cx: 0, cy: 0, r: (0.6 * kHalf).toFixed(1) });
    seen.forEach(([x, y], i) => place(picture.children[i + 1]!, { cx: (scale * x).toFixed(1), cy: (-scale * y).toFixed(1) }));
    const words = `tips of ${apart.length} worlds, seen along the needle; ring ${ring} mm, spread ${(1e3 * spread).toFixed(2)} mm`;
    if (element("spread").textContent !== words) element("spread").replaceChildren(spot(kColour), words);
  }
}

const css = `#${kColour.toString(16)}`;

function mark(kind: string, attributes: Record<string, string | number>): SVGElement {
  const element = document.createElementNS("http://www.w3.org/2000/svg", kind);
  place(element, attributes);
  return element;
}

function place(element: Element, attributes: Record<string, string | number>): void {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
}
