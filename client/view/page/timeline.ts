// SPDX-License-Identifier: MIT
// The time line of a recording: which moment is shown, how much is there, play, and the way back from a live server.
import type { Link } from "./link.js";
import type { Run } from "./messages.js";
import { element } from "./panel.js";

const kPeriod = 80; // ms between two moments that are asked for
const at = (): HTMLInputElement => element<HTMLInputElement>("at");

export class Timeline {
  private run: Run | null = null;
  private asked = 0; // ms
  private later = 0; // timer
  private held = false; // the slider, in a hand
  private wanted = 0; // s, where it was put last

  constructor(private link: Link) {
    element("run-play").addEventListener("click", () => link.say({ run: !this.run?.playing }));
    element("run-back").addEventListener("click", () => link.say({ branch: false }));
    at().addEventListener("input", () => ((this.wanted = Number(at().value)), this.seek()));
    at().addEventListener("pointerdown", () => (this.held = true));
    for (const end of ["pointerup", "pointercancel", "change"]) at().addEventListener(end, () => (this.held = false));
  }

  // `mine`: whether this page may end what another drives.
  show(run: Run | null, mine: boolean): void {
    this.run = run;
    element("timeline").hidden = run === null;
    if (!run) return;
    for (const id of ["run-play", "at", "run-time"]) element(id).hidden = run.live;
    element("run-back").hidden = !run.live;
    element<HTMLButtonElement>("run-back").disabled = !mine;
    element("run-play").textContent = run.playing ? "❚❚" : "▶";
    element("run-play").setAttribute("aria-label", run.playing ? "Stop the recording" : "Play the recording");
    at().max = String(run.length);
    if (!this.held && this.later === 0) at().value = String(run.at);
    element("run-time").textContent = `${run.at.toFixed(2)} of ${run.length.toFixed(2)} s${run.whole ? "" : " …"}`;
  }

  // The newest moment, and not too often.
  private seek(): void {
    const wait = this.asked + kPeriod - performance.now();
    clearTimeout(this.later);
    this.later = 0;
    if (wait > 0) {
      this.later = window.setTimeout(() => this.seek(), wait);
      return;
    }
    this.asked = performance.now();
    if (this.run?.playing) this.link.say({ run: false });
    this.link.say({ seek: this.wanted });
  }
}
