// SPDX-License-Identifier: MIT
// The words beside the picture: what runs and how well, what happened, and the legend.
import { eventColours } from "./marks.js";
import { inWords, type Event, type Force, type HelloReply, type Stats } from "./messages.js";

export const element = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;
const text = (id: string, words: string): void => {
  const node = element(id);
  if (node.textContent !== words) node.textContent = words;
};
const css = (colour: number): string => `#${colour.toString(16).padStart(6, "0")}`;

const phases: Record<string, string> = {
  free: "free", contact: "touching", inside: "in the tissue", through: "through",
};
const kMostEvents = 6;
const kMostNames = 2; // of needles, in a line

// A spot of colour before words; SVG, since the page's policy permits no style in attributes.
export function spot(colour: number | string): SVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const circle = document.createElementNS("http://www.w3.org/2000/svg", "circle");
  svg.setAttribute("viewBox", "0 0 10 10");
  for (const [name, value] of Object.entries({ cx: "5", cy: "5", r: "5", fill: typeof colour === "string" ? colour : css(colour) })) circle.setAttribute(name, value);
  svg.append(circle);
  return svg;
}

export function showStatus(words: string, bad: boolean): void {
  text("status", words);
  element("status").classList.toggle("bad", bad);
}

let noticeEnds = 0;
export function notice(words: string): void {
  text("notice", words);
  element("notice").hidden = false;
  clearTimeout(noticeEnds);
  noticeEnds = window.setTimeout(() => (element("notice").hidden = true), 6000);
}

export function showScene(hello: HelloReply): void {
  text("scene", hello.scene || "Acus");
  document.title = `${hello.scene} – Acus`;
  element("needle").replaceChildren(...hello.needles.map((needle) => new Option(needle.name)));
  element<HTMLButtonElement>("hold").disabled = hello.needles.length === 0;
}

// `scale` says in words what the largest value is, where the tissue is not in the colours of its regions.
export function showLegend(regions: string[], shades: number[], scale: string | null): void {
  const items = regions.map((name, region) => {
    const item = document.createElement("span");
    item.append(spot(shades[region]!), name);
    return item;
  });
  if (scale !== null) {
    const item = document.createElement("span");
    item.textContent = `blue 0 – yellow ${scale}`;
    items.splice(0, items.length, item);
  }
  element("legend").replaceChildren(...items);
}

function heldInWords(names: string[]): string {
  const shown = names.slice(0, kMostNames).join(", ");
  return names.length > kMostNames ? `${shown} and ${names.length - kMostNames} more` : shown || "by nobody";
}

export function showFigures(hello: HelloReply | null, force: Force | null, stats: Stats | null): void {
  const rows: [string, string][] = [];
  if (stats && hello) {
    const rate = stats.period > 0 ? stats.ticks / stats.period : 0;
    rows.push(["ticks", hello.lockstep ? "on request" : `${rate.toFixed(0)}/s, ${stats.late} late`]);
    if (stats.ticks > 0) rows.push(["each takes", `${(1e3 * stats.tick_p50).toFixed(2)} ms`]);
  }
  if (force) {
    rows.push(["time", `${force.time.toFixed(2)} s`]);
    rows.push(["needle", phases[force.phase] ?? force.phase]);
    rows.push(["depth", `${(1e3 * force.depth).toFixed(1)} mm`]);
    rows.push(["base force", `${Math.hypot(...force.base_force).toFixed(3)} N`]);
    rows.push(["flags", inWords(force.flags)]);
  }
  if (hello) rows.push(["held", heldInWords(hello.held)]);
  const list = element("figures");
  if (list.childElementCount !== 2 * rows.length)
    list.replaceChildren(...rows.flatMap(() => [document.createElement("dt"), document.createElement("dd")]));
  rows.forEach(([name, value], i) => {
    if (list.children[2 * i]!.textContent !== name) list.children[2 * i]!.textContent = name;
    if (list.children[2 * i + 1]!.textContent !== value) list.children[2 * i + 1]!.textContent = value;
  });
}

export function showFelt(force: Force | null): void {
  const felt = force ? Math.hypot(...force.haptic_force) : 0;
  element<HTMLMeterElement>("felt").value = felt;
  text("felt-value", force ? `${felt.toFixed(2)} N` : "");
}

export function addEvent(event: Event): void {
  const item = document.createElement("li");
  const where = event.region ? ` ${event.region}` : "";
  item.append(spot(eventColours[event.kind] ?? 0x9aa5b1),
              ` ${event.time.toFixed(2)} s  ${event.kind}${where}, ${Math.abs(event.force).toFixed(2)} N (${event.needle})`);
  const list = element("events");
  list.prepend(item);
  while (list.childElementCount > kMostEvents) list.lastElementChild!.remove();
}

export const clearEvents = (): void => element("events").replaceChildren();
