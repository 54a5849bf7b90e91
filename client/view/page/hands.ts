// SPDX-License-Identifier: MIT
// A hand on the needle: mouse, wheel, keys or a gamepad move a goal, the commanded pose follows it at a bounded speed,
// and goes to the server sixty times a second, also while it rests, so that it does not count as stale.
import { Plane, Quaternion, Raycaster, Vector2, Vector3 } from "./vendor/libraries.js";
import type { Link } from "./link.js";
import type { Force } from "./messages.js";
import { quaternion, type NeedleTube } from "./needles.js";
import type { Stage } from "./stage.js";

const kFastest = 0.1; // m/s of the commanded pose
const kSlow = 0.015, kQuick = 0.06; // m/s, of keys, without and with Shift
const kTurn = 2; // rad/s
const kWheel = 0.0015; // m, of one notch
const kMostFelt = 5; // N, that a pad tells apart
const kNear = 24; // px from the needle where a drag takes it

export class Hands {
  holding: string | null = null;
  waiting = false; // for the needle to be elsewhere: nothing is sent
  private still = false;  // simulation time stands: what the hand does moves nothing, also not later
  felt = 0; // N
  private place = new Vector3();
  private goal = new Vector3();
  private orientation = new Quaternion();
  private spin = 0;
  private seq = 0;
  private keys = new Set<string>();
  private quick = false;
  private drag: { plane: Plane; from: Vector3; goal: Vector3 } | null = null;
  private last = performance.now();

  constructor(private stage: Stage, private link: Link, private needle: () => NeedleTube | undefined) {
    const canvas = stage.renderer.domElement;
    canvas.addEventListener("pointerdown", (event) => this.take(event), true);
    canvas.addEventListener("pointermove", (event) => this.pull(event));
    for (const end of ["pointerup", "pointercancel"] as const) canvas.addEventListener(end, () => this.let());
    canvas.addEventListener("wheel", (event) => this.wheel(event), { capture: true, passive: false });
    addEventListener("keydown", (event) => this.key(event, true));
    addEventListener("keyup", (event) => this.key(event, false));
    addEventListener("blur", () => this.keys.clear());
    setInterval(() => this.beat(), 1000 / 60);
  }

  // Goes on from where the commands have the base.
  hold(force: Force): void {
    this.holding = force.needle;
    this.place.set(...force.commanded_position);
    this.goal.copy(this.place);
    this.orientation.copy(quaternion(force.commanded_orientation));
    this.spin = force.spin;
    this.waiting = false;
  }

  set paused(paused: boolean) {
    if (paused && !this.still) this.let();
    this.still = paused;
  }

  release(): void {
    this.holding = null;
    this.waiting = false;
    this.keys.clear();
    this.let();
  }

  private get axis(): Vector3 {
    return new Vector3(1, 0, 0).applyQuaternion(this.orientation);
  }

  private ray(event: PointerEvent): Raycaster {
    const box = this.stage.renderer.domElement.getBoundingClientRect();
    const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const caster = new Raycaster();
    caster.setFromCamera(at, this.stage.camera);
    return caster;
  }

  // A drag that begins at the needle moves it across its own axis; all others look around.
  private take(event: PointerEvent): void {
    const needle = this.needle();
    if (!this.holding || this.still || !needle || event.button !== 0) return;
    const box = this.stage.renderer.domElement.getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    let near = Infinity, grip = needle.point(0);
    for (let i = 0; i < needle.nodes; ++i) {
      const pixel = this.stage.pixel(needle.point(i)), distance = Math.hypot(pixel.x - x, pixel.y - y);
      if (distance < near) (near = distance), (grip = needle.point(i));
    }
    if (near > kNear) return;
    event.stopImmediatePropagation();
    this.stage.renderer.domElement.setPointerCapture(event.pointerId);
    const view = this.stage.camera.getWorldDirection(new Vector3());
    const plane = new Plane().setFromNormalAndCoplanarPoint(view, grip);
    const from = this.ray(event).ray.intersectPlane(plane, new Vector3());
    if (from) this.drag = { plane, from, goal: this.goal.clone() };
  }

  private pull(event: PointerEvent): void {
    if (!this.drag) return;
    const to = this.ray(event).ray.intersectPlane(this.drag.plane, new Vector3());
    if (!to) return;
    const way = to.sub(this.drag.from);
    way.addScaledVector(this.axis, -way.dot(this.axis)); // depth is the wheel's
    const along = this.goal.clone().sub(this.drag.goal).dot(this.axis);
    this.goal.copy(this.drag.goal).add(way).addScaledVector(this.axis, along);
  }

  private let(): void {
    this.drag = null;
  }

  private wheel(event: WheelEvent): void {
    if (!this.holding) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!this.still) this.goal.addScaledVector(this.axis, Math.max(-1, Math.min(1, -event.deltaY / 100)) * kWheel);
  }

  private key(event: KeyboardEvent, down: boolean): void {
    this.quick = event.shiftKey;
    const key = event.key.toLowerCase();
    if (!down) return void this.keys.delete(key);
    const writing = event.target instanceof HTMLInputElement && !["checkbox", "range"].includes(event.target.type);
    if (writing || event.target instanceof HTMLSelectElement || event.ctrlKey || event.metaKey) return;
    if (!["w", "s", "q", "e"].includes(key) && !key.startsWith("arrow")) return;
    if (this.holding) event.preventDefault();
    this.keys.add(key);
  }

  // How far keys and gamepad push: along the needle, and across it to the right and up as seen; and how they turn it.
  private pressed(): {along: number; right: number; up: number; turn: number} {
    const pressed = (more: string, less: string): number => Number(this.keys.has(more)) - Number(this.keys.has(less));
    const push = {
      along: pressed("w", "s"), right: pressed("arrowright", "arrowleft"), up: pressed("arrowup", "arrowdown"), turn: pressed("e", "q"),
    };
    const pad = navigator.getGamepads?.().find((each) => each !== null);
    const axis = (i: number): number => (Math.abs(pad?.axes[i] ?? 0) > 0.12 ? pad!.axes[i]! : 0);
    return { along: push.along - axis(3), right: push.right + axis(0), up: push.up - axis(1), turn: push.turn + axis(2) };
  }

  // As hard as the force that is felt, where the pad can.
  private rumble(): void {
    const pad = navigator.getGamepads?.().find((each) => each !== null);
    const strength = Math.min(1, this.felt / kMostFelt);
    if (pad?.vibrationActuator && strength > 0.02)
      void pad.vibrationActuator.playEffect("dual-rumble", { duration: 60, strongMagnitude: strength, weakMagnitude: 0 });
  }

  private beat(): void {
    const now = performance.now(), dt = Math.min((now - this.last) / 1000, 0.1);
    this.last = now;
    if (!this.holding || this.waiting) return;
    if (this.still)
      this.goal.copy(this.place);
    else
      this.push(dt);
    this.rumble();
    const {w, x, y, z} = this.orientation;
    this.link.send('pose', {
      needle: this.holding,
      seq: ++this.seq,
      time: now / 1000,
      position: this.place.toArray(),
      orientation: [w, x, y, z],
      spin: this.spin,
    });
  }

  // Moves the goal as keys and gamepad say, and the commanded pose towards it.
  private push(dt: number): void {
    const push = this.pressed(), speed = (this.quick ? kQuick : kSlow) * dt, axis = this.axis;
    const right = new Vector3().setFromMatrixColumn(this.stage.camera.matrixWorld, 0);
    const up = new Vector3().setFromMatrixColumn(this.stage.camera.matrixWorld, 1);
    for (const side of [right, up]) side.addScaledVector(axis, -side.dot(axis));
    this.goal.addScaledVector(axis, push.along * speed).addScaledVector(right, push.right * speed).addScaledVector(up, push.up * speed);
    this.spin += push.turn * kTurn * dt;
    const way = this.goal.clone().sub(this.place);
    this.place.addScaledVector(way, Math.min(1, (kFastest * dt) / Math.max(way.length(), 1e-12)));
  }
}
