// SPDX-License-Identifier: MIT
// The messages of protocol/README.md that the page reads and sends, and what packed numbers become.
export type Vector = [number, number, number];
export type Quat = [number, number, number, number]; // w, x, y, z

export interface HelloReply {
  type: "hello_reply"; instance: number; scene: string; epoch: number; rate: number; time_step: number;
  lockstep: boolean; paused: boolean; held: string[]; recording?: string; file?: string; server: string;
  needles: { name: string; length: number; diameter: number; hub_diameter?: number; nodes: number; base_position: Vector; base_orientation: Quat; cutting_direction: Vector }[];
  guides: { name: string; needle: string; position: Vector; orientation: Quat }[];
  tissue: { nodes: number; tetrahedra: number; triangles: number };
}
export interface DescribeReply {
  type: "describe_reply"; epoch: number; positions: Uint8Array; triangles: Uint8Array; tetrahedra: Uint8Array;
  regions: string[]; region_colours: string[]; tetrahedron_regions: Uint8Array; needles: { name: string; positions: Uint8Array }[];
}
export interface Force {
  type: "force"; epoch: number; tick: number; time: number; needle: string; phase: string; depth: number; unheld: number;
  stale: boolean; base_position: Vector; base_orientation: Quat; commanded_position: Vector; commanded_orientation: Quat;
  spin: number; tip_position: Vector; tip_force: Vector; base_force: Vector; base_force_in_base: Vector;
  haptic_force: Vector; cutting_force: Vector; friction_force: Vector; lateral_force: Vector; flags: number;
}
export interface NeedleShape {
  type: "needle"; epoch: number; tick: number; time: number; needle: string; positions: Uint8Array; orientations: Uint8Array;
}
export interface TissueShape {
  type: "tissue"; epoch: number; tick: number; time: number; positions: Uint8Array; path_points: Uint8Array; path_sizes: Uint8Array;
  dent_centres?: Uint8Array; dent_moves?: Uint8Array; dent_radii?: Uint8Array; // not in old records
}
export interface Event {
  type: "event"; epoch: number; tick: number; time: number; needle: string; kind: string; region: string; position: Vector; force: number;
}
export interface Stats {
  type: "stats"; epoch: number; period: number; paused: boolean; ticks: number; late: number; end_p99: number; tick_p50: number;
  overruns: number; dropped: number; rows: number; flags: number; recording: string;
}
export interface CloudOfTips { // of acus-cloud
  type: "cloud"; epoch: number; tick: number; time: number; behind: number;
  needles: { name: string; tips: Uint8Array; spread: number; error: number }[];
}
export interface ServerError { type: "error"; seq?: number; rejected?: string; code: string; message: string }
export interface Done { type: "done"; seq: number; epoch: number; tick: number }
export interface Holding { type: "holding"; seq: number; needles: string[] }
export interface SnapshotReply { type: "snapshot_reply"; seq: number; snapshot: Uint8Array; time: number }
export type Message =
  | HelloReply | DescribeReply | Force | NeedleShape | TissueShape | Event | Stats | CloudOfTips | ServerError | Done | Holding | SnapshotReply;

// What the gateway says (client/view/gateway.h).
export interface Standing { server: boolean; driving: boolean; driven: boolean; playing: string; viewers: number; lost: number; run: Run | null }
export interface Run { at: number; length: number; whole: boolean; playing: boolean; live: boolean } // s
export interface Choices { scenes: Record<string, string>; motions: string[]; records: boolean }

const copy = (bytes: Uint8Array): ArrayBuffer => bytes.slice().buffer as ArrayBuffer; // aligned
export const float32 = (bytes: Uint8Array): Float32Array => new Float32Array(copy(bytes));
export const float64 = (bytes: Uint8Array): Float64Array => new Float64Array(copy(bytes));
export const int32 = (bytes: Uint8Array): Int32Array => new Int32Array(copy(bytes));

// Bits of `flags`, in words for people.
export const flagWords = [
  "residual too large", "not converged", "needle near buckling", "too many constraint points", "path full",
  "tick refused: not finite", "fell back to Gauss–Seidel", "late: fewer solver steps", "late: fewer iterations",
  "late: fewer shapes", "step cut", "tissue crushed", "tip found inside", "forces unbalanced", "shaft crosses tissue unheld",
  "energy gained", "needle overstrained", "base at its speed limit",
];
export const inWords = (flags: number): string =>
  flagWords.filter((_, bit) => (flags >>> bit) & 1).join(", ") || "none";
