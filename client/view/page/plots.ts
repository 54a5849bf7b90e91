// SPDX-License-Identifier: MIT
// Force and depth of the chosen needle over the last twenty seconds of simulation time, or over all of a recording.
import { uPlot } from "./vendor/libraries.js";
import type { Force } from "./messages.js";
import { spot } from "./panel.js";

const kWindow = 20; // s
const kPeriod = 100; // ms between two drawings
const kMost = 6000;  // points of a curve of a recording: beyond, every second one goes
const size = (v: readonly number[]): number => Math.hypot(v[0]!, v[1]!, v[2]!);

interface Curve { label: string; stroke: string; of(force: Force): number }
interface Chart { title: string; height: number; curves: Curve[] }
const charts: Chart[] = [
  {
    title: "at the base (N)", height: 90,
    curves: [
      { label: "along", stroke: "#d7263d", of: (f) => -f.base_force_in_base[0] },
      { label: "across", stroke: "#2a6fdb", of: (f) => Math.hypot(f.base_force_in_base[1], f.base_force_in_base[2]) },
    ],
  },
  {
    title: "by the tissue (N)", height: 84,
    curves: [
      { label: "at the tip", stroke: "#f08a24", of: (f) => size(f.cutting_force) },
      { label: "friction", stroke: "#2a9d5c", of: (f) => size(f.friction_force) },
    ],
  },
  { title: "depth (mm)", height: 78, curves: [{ label: "depth", stroke: "#7b5ea7", of: (f) => 1e3 * f.depth }] },
];

function heading(chart: Chart): HTMLElement {
  const line = document.createElement("p");
  line.className = "heading";
  const names = chart.curves.map((curve) => [spot(curve.stroke), curve.label]);
  line.append(chart.title, ...(chart.curves.length > 1 ? names.flat() : [spot(chart.curves[0]!.stroke)]));
  return line;
}

export class Plots {
  private plots: uPlot[];
  times: number[] = []; // s
  length: number|null = null;  // s, of the recording that is shown
  private values: number[][][] = charts.map((chart) => chart.curves.map(() => []));
  private drawnAt = 0;
  private later = 0; // timer

  constructor(host: HTMLElement) {
    const ink = () => getComputedStyle(document.body).color;
    matchMedia('(prefers-color-scheme: dark)')
        .addEventListener('change', () => this.plots.forEach((plot) => plot.redraw(false)));
    const axis = { stroke: ink, grid: { stroke: "rgba(128,128,128,0.2)" }, ticks: { show: false }, size: 38, font: "11px system-ui" };
    this.plots = charts.map((chart) => {
      host.append(heading(chart));
      const series = chart.curves.map((curve) => ({
        label: curve.label, stroke: curve.stroke, width: 1.4, points: { show: false },
      }));
      return new uPlot(
        {
          width: 350, height: chart.height, series: [{}, ...series], legend: { show: false },
          scales: { x: { time: false }, y: { range: (_u: uPlot, low: number, high: number) => [Math.min(low, 0), Math.max(high, 0.1) * 1.05] } },
          axes: [{ ...axis, size: 18 }, { ...axis, space: 22 }], cursor: { drag: { x: false, y: false } },
        },
        [[], ...chart.curves.map(() => [])], host);
    });
  }

  clear(): void {
    this.times = [];
    this.values = charts.map((chart) => chart.curves.map(() => []));
    this.draw(true);
  }

  add(force: Force): void {
    const last = this.times[this.times.length - 1];
    if (last !== undefined && force.time <= last) return;
    this.times.push(force.time);
    charts.forEach((chart, c) => chart.curves.forEach((curve, i) => this.values[c]![i]!.push(curve.of(force))));
    if (this.length === null && this.times[0]! < force.time - 1.5 * kWindow) {
      const from = this.times.findIndex((t) => t >= force.time - kWindow);
      this.keep((_, i) => i >= from);
    }
    if (this.times.length > kMost) this.keep((_, i) => i % 2 === 0);
    this.draw(false);
  }

  private keep(which: (value: number, i: number) => boolean): void {
    this.times = this.times.filter(which);
    this.values = this.values.map((chart) => chart.map((curve) => curve.filter(which)));
  }

  // s, from the first moment that is drawn to the last.
  get span(): {min: number; max: number} {
    const first = this.times[0] ?? 0, end = this.times[this.times.length - 1] ?? kWindow;
    if (this.length !== null) return {min: first, max: Math.max(first + this.length, end)};
    return {min: Math.max(0, end - kWindow), max: Math.max(end, kWindow)};
  }

  draw(now: boolean): void {
    const time = performance.now(), left = this.drawnAt + kPeriod - time;
    if (!now && left > 0) {
      this.later ||= window.setTimeout(() => this.draw(true), left);
      return;
    }
    clearTimeout(this.later);
    this.later = 0;
    this.drawnAt = time;
    this.plots.forEach((plot, c) => {
      plot.setData([this.times, ...this.values[c]!] as uPlot.AlignedData, false);
      plot.setScale('x', this.span);
    });
  }
}
