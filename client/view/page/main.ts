// SPDX-License-Identifier: MIT
// The page: takes what the gateway sends, keeps the newest, and draws it.
import { Group, Mesh, Vector3 } from "./vendor/libraries.js";
import { chosenMotion, chosenScene, offer, recordingName, showChoice, takeHome } from "./choices.js";
import { Cloud } from "./cloud.js";
import { Hands } from "./hands.js";
import { Link } from "./link.js";
import { Marks } from "./marks.js";
import { float64, type Choices, type Force, type HelloReply, type Message, type Standing, type Stats } from "./messages.js";
import { guideRing, NeedleTube } from "./needles.js";
import { addEvent, clearEvents, element, notice, showFelt, showFigures, showLegend, showScene, showStatus } from "./panel.js";
import { Plots } from "./plots.js";
import { Stage } from "./stage.js";
import { Timeline } from "./timeline.js";
import { Tissue } from "./tissue.js";

let hello: HelloReply | null = null;
let standing: Standing = { server: false, driving: false, driven: false, playing: "", viewers: 0, lost: 0, run: null };
let stats: Stats | null = null;
let tissue: Tissue | null = null;
let needles = new Map<string, NeedleTube>();
let forces = new Map<string, Force>();
let kept: Uint8Array | null = null;
let drawn = -1; // tick
let epoch = -1; // of the newest state
let asking = false; // a request is under way
let jumped = 0; // how often what was told became void
let shapes = 0; // since then
let follows = false; // a server goes on from the moment of the recording that is shown: what was told before stays
let built = ""; // what of the scene is drawn
const guides = new Group();
const marks = new Marks();
const cloud = new Cloud();
const plots = new Plots(element("plots"));
const stage = new Stage(element("stage"), beforeDrawing);
stage.scene.add(marks.group, guides, cloud.group);
const link = new Link(location.hash.slice(1), { message, standing: stand, choices: chooseFrom, notice, jumped: forget, lost, damaged });
const timeline = new Timeline(link);
const hands = new Hands(stage, link, () => needles.get(hands.holding ?? chosen()));

// A recording is shown, and no server has gone on from it.
const replayed = (): boolean => standing.run !== null && !standing.run.live;

function chosen(): string {
  return element<HTMLSelectElement>("needle").value;
}

function beforeDrawing(): void {
  const force = forces.get(chosen()), needle = needles.get(chosen());
  if (tissue && needle) {
    const along = needle.point(needle.nodes - 1).sub(needle.point(0)).normalize();
    const view = stage.camera.getWorldDirection(new Vector3());
    const normal = view.addScaledVector(along, -view.dot(along)).normalize();
    tissue.slice(needle.point(needle.nodes - 1), normal);
  }
  const length = 0.12 * stage.size; // m of an arrow, of one newton
  for (const each of forces.values()) {
    const base = new Vector3(...each.base_position), tip = new Vector3(...each.tip_position);
    marks.arrow(each.needle + " base", base, new Vector3(...each.base_force), length, 0xf08a24);
    marks.arrow(each.needle + " tip", tip, new Vector3(...each.tip_force), length, 0xd7263d);
  }
  cloud.draw(needles, chosen());
  showFelt(force ?? null);
  if (replayed()) showFigures(hello, force ?? null, stats); // show() comes before the forces
  hands.felt = force ? Math.hypot(...force.haptic_force) : 0;
  drawn = force?.tick ?? drawn;
}

// What was told of an epoch is over when another begins: its first message comes before `hello_reply` tells of it.
function renew(next: number): void {
  if (next === epoch) return;
  epoch = next;
  if (!follows) forget();
}

function forget(): void {
  ++jumped;
  shapes = 0;
  forces = new Map();
  marks.clear();
  cloud.clear();
  plots.clear();
  clearEvents();
}

// Another scene, or another server: needles and guides anew. The tissue comes with its description.
function build(next: HelloReply): void {
  if (hello && hello.instance !== next.instance) letGo();
  const said = JSON.stringify([next.scene, next.needles, next.guides, next.tissue]);
  if (said === built) return;
  built = said;
  kept = null;
  showScene(next);
  for (const needle of needles.values()) stage.scene.remove(needle.group), needle.dispose();
  needles = new Map(next.needles.map((needle) => [needle.name, new NeedleTube(needle)]));
  for (const needle of needles.values()) stage.scene.add(needle.group);
  for (const ring of guides.children) (ring as Mesh).geometry.dispose();
  guides.clear();
  for (const guide of next.guides)
    guides.add(guideRing(guide, (next.needles.find((needle) => needle.name === guide.needle)?.diameter ?? 0.001) / 2));
  setTissue(null);
  lookAtAll();
}

function setTissue(next: Tissue | null): void {
  if (tissue) stage.scene.remove(tissue.group), tissue.dispose();
  tissue = next;
  if (tissue) stage.scene.add(tissue.group);
  choose();
}

function lookAtAll(): void {
  const low = tissue?.low.clone() ?? new Vector3(Infinity, Infinity, Infinity);
  const high = tissue?.high.clone() ?? new Vector3(-Infinity, -Infinity, -Infinity);
  for (const needle of needles.values())
    for (const node of [0, needle.nodes - 1]) low.min(needle.point(node)), high.max(needle.point(node));
  if (low.x <= high.x) stage.frame(low, high);
}

// What to draw, as chosen beside the picture.
function choose(): void {
  if (tissue) {
    tissue.colourBy(element<HTMLSelectElement>("colour").value as Tissue["colouring"]);
    tissue.skinVisible = element<HTMLInputElement>("skin").checked;
    tissue.cutVisible = element<HTMLInputElement>("cut").checked;
  }
  showScale();
  stage.draw();
}

function showScale(): void {
  const largest = tissue?.largest ?? 0;
  const scales = { regions: null, displacement: `${(1e3 * largest).toFixed(1)} mm`, strain: `${(100 * largest).toFixed(0)} % strain` };
  showLegend(tissue?.regions ?? [], tissue?.shades ?? [], scales[tissue?.colouring ?? "regions"]);
}

function message(message: Message): void {
  if (["force", "needle", "tissue", "event"].includes(message.type)) renew((message as Force).epoch);
  switch (message.type) {
    case "hello_reply": {
      const another = hello?.instance !== message.instance;
      if (another) epoch = -1;
      renew(message.epoch);
      if (another) follows = false;
      build(message);
      hello = message;
      show();
      break;
    }
    case "describe_reply":
      if (!hello?.tissue.nodes || tissue?.is(message)) break;
      setTissue(new Tissue(message));
      lookAtAll();
      break;
    case "force":
      forces.set(message.needle, message);
      if (message.needle === chosen()) plots.add(message);
      stage.draw();
      break;
    case "needle":
      ++shapes;
      needles.get(message.needle)?.update(float64(message.positions), float64(message.orientations));
      stage.draw();
      break;
    case "tissue":
      ++shapes;
      tissue?.update(message);
      marks.path(message);
      if (tissue && tissue.colouring !== "regions") showScale();
      stage.draw();
      break;
    case "event":
      marks.event(message);
      addEvent(message);
      break;
    case "cloud":
      if (message.epoch !== epoch) break;
      cloud.take(message);
      stage.draw();
      break;
    case "stats":
      stats = message;
      if (hello && !asking) hello = {...hello, paused: message.paused};  // whoever paused it
      show();
      break;
    case "error":
      notice(message.message);
      break;
  }
}

function statusWords(): string {
  if (!standing.server && replayed()) return "the recording is being read";
  if (!standing.server) return standing.run ? "the server runs the recording again up to there" : "the server does not answer";
  if (replayed()) return `a recording, ${standing.viewers} looking`;
  const clock = hello?.paused ? "paused, " : hello?.lockstep ? "lockstep, " : "";
  const driven = standing.playing ? `plays ${standing.playing.replaceAll("_", " ")}`
    : standing.driving ? "you drive" : standing.driven ? "another page drives" : "nobody drives";
  return `${clock}${standing.viewers} looking, ${driven}` + (standing.lost > 0 ? `, ${standing.lost} events lost` : "");
}

function show(): void {
  showStatus(statusWords(), !standing.server && !standing.run);
  timeline.show(standing.run, standing.driving || !standing.driven);
  plots.length = replayed() ? standing.run!.length : null;
  hands.paused = hello?.paused ?? false;
  showFigures(hello, forces.get(chosen()) ?? null, stats);
  const mine = standing.server && (standing.driving || !standing.driven), free = mine && !standing.playing && !asking;
  showChoice(hello?.file ?? "");
  const hold = element<HTMLButtonElement>("hold");
  hold.textContent = hands.holding ? "Let it go" : replayed() ? "Take the needle from here" : "Take the needle";
  hold.setAttribute("aria-pressed", String(hands.holding !== null));
  hold.disabled = !mine || needles.size === 0;
  const play = element<HTMLButtonElement>("play"), record = element<HTMLButtonElement>("record");
  play.textContent = standing.playing ? "Stop" : "Play";
  play.disabled = !mine || chosenMotion() === "";
  record.textContent = hello?.recording ? "Save" : "Record";
  record.setAttribute("aria-pressed", String(hello?.recording !== undefined));
  for (const id of ["scenes", "motions"]) element<HTMLSelectElement>(id).disabled = !free;
  element("pause").textContent = hello?.paused ? "Go on" : "Pause";
  for (const id of ["pause", "reset", "keep", "step", "record"]) element<HTMLButtonElement>(id).disabled = !free;
  for (const id of ["reset", "keep", "back"]) element(id).hidden = replayed();
  element("load").hidden = standing.run !== null || !element("choices").hidden;
  element("step").hidden = replayed() || !hello?.lockstep;
  element("pause").hidden = replayed() || (hello?.lockstep ?? false);
  element<HTMLButtonElement>("back").disabled = !free || kept === null;
  for (const [name, needle] of needles) needle.held = hands.holding === name;
}

function stand(next: Standing): void {
  follows = next.run?.live === true && (follows || replayed());
  standing = next;
  if (!standing.driving || !standing.server) hands.release();
  if (replayed()) stats = null;
  show();
}

function chooseFrom(choices: Choices): void {
  offer(choices);
  show();
}

function lost(why: string): void {
  standing = { ...standing, server: false, driving: false };
  hands.release();
  show();
  showStatus(why, true);
}

function damaged(why: string): void {
  notice(`a damaged message was left out: ${why}`);
}

// Waits for it, at most so many seconds.
async function waitFor(what: () => boolean, seconds = 1): Promise<boolean> {
  for (let i = 0; i < 40 * seconds && !what(); ++i) await new Promise((done) => setTimeout(done, 25));
  return what();
}

// Waits until this page drives, or does not.
async function drive(): Promise<boolean> {
  if (!standing.driving || !link.wantsToDrive) link.drive(true);
  const ours = await waitFor(() => standing.driving);
  if (!ours) notice("another page drives");
  return ours;
}

// What the needle says of itself in an epoch, if it does within a second.
async function told(needle: string, of: number): Promise<Force | undefined> {
  const come = await waitFor(() => forces.get(needle)?.epoch === of);
  return come ? forces.get(needle) : undefined;
}

async function takeOrLet(): Promise<void> {
  if (hands.holding) {
    letGo();
    return show();
  }
  const shown = replayed() ? forces.get(chosen()) : undefined;
  if (!(await goLive()) || !(await stopMotion()) || !(await drive())) return;
  const answer = await link.request("acquire", { needles: [chosen()] });
  if (hello?.lockstep) await link.request("step", { ticks: 1 });
  const force = shown ?? (await told(chosen(), hello?.epoch ?? 0));
  if (answer.type === "holding" && force) {
    hands.hold(force);
    if (shown && (await link.request("resume")).type === "done" && hello) hello = { ...hello, paused: false };
  } else {
    if (!force) notice("the needle does not tell where it is: is the simulation paused?");
    link.drive(false);
  }
  element("stage").focus();
  show();
}

function letGo(): void {
  hands.release();
  if (link.wantsToDrive) link.drive(false);
}

// A request of somebody who need not hold a needle: this page drives for it, if no other does.
async function ask(type: string, fields: object = {}): Promise<Message | null> {
  if (asking) return null;
  asking = true;
  show();
  const answer = (await drive()) ? await link.request(type, fields) : null;
  if (answer && !hands.holding) letGo();
  asking = false;
  show();
  return answer;
}

async function keep(): Promise<void> {
  const answer = await ask("snapshot");
  if (answer?.type === "snapshot_reply") kept = answer.snapshot;
  show();
}

// `reset` and `restore` put the needle elsewhere: the hand goes on from there.
async function jump(type: string, fields: object): Promise<void> {
  const held = hands.holding;
  hands.waiting = true;
  const answer = await ask(type, fields);
  if (!held || answer?.type !== "done") {
    hands.waiting = false;
    return;
  }
  if (hello?.lockstep) await link.request("step", { ticks: 1 });
  const force = await told(held, answer.epoch);
  if (force && hands.holding === held) hands.hold(force);
  else letGo();
  show();
}

// From the scene's start; whoever takes the needle ends it.
async function playOrStop(): Promise<void> {
  if (standing.playing) return link.say({ play: null });
  const motion = chosenMotion();
  letGo();
  if ((await ask("reset"))?.type === "done") link.say({ play: motion });
}

// From the moment of the recording that is shown, paused until the needle is held.
async function goLive(): Promise<boolean> {
  if (!replayed()) return true;
  link.say({ branch: true });
  const instance = hello?.instance;
  return waitFor(() => standing.run?.live === true && standing.server && hello?.instance !== instance, 600);
}

async function stopMotion(): Promise<boolean> {
  if (!standing.playing) return true;
  link.say({ play: null });
  const free = await waitFor(() => !standing.playing && !hello?.held.includes(chosen()));
  if (!free) notice("the motion does not end");
  return free;
}

async function recordOrSave(): Promise<void> {
  const name = hello?.recording, next = recordingName();
  const answer = await ask("record", name ? {} : { file: next });
  if (answer?.type !== "done" || !hello) return;
  const { recording, ...rest } = hello;
  hello = recording ? rest : { ...rest, recording: next };
  show();
  if (name && !(await takeHome(name, link.token))) notice(`${name} cannot be fetched`);
}

// After it nobody holds anything.
async function load(scene: string): Promise<void> {
  if (!scene) return;
  hands.waiting = true;
  const answer = await ask("load", { scene });
  hands.waiting = false;
  if (answer?.type === "done") letGo();
  show();
}

async function pauseOrGoOn(): Promise<void> {
  const paused = hello?.paused ?? false;
  if ((await ask(paused ? "resume" : "pause"))?.type === "done" && hello) hello = { ...hello, paused: !paused };
  show();
}

const on = (id: string, what: () => unknown, event = "click"): void => element(id).addEventListener(event, () => void what());
on("hold", takeOrLet);
on("pause", pauseOrGoOn);
on("play", playOrStop);
on("record", recordOrSave);
on("scenes", () => load(chosenScene()), "change");
on("motions", show, "change");
on("step", () => ask("step", { ticks: 10 }));
on("reset", () => jump("reset", {}));
on("keep", keep);
on("back", () => kept && jump("restore", { snapshot: kept }));
for (const id of ["colour", "cut", "skin"]) on(id, choose, "change");
on("needle", () => (plots.clear(), show(), stage.draw()), "change");
element("load").addEventListener("submit", (event) => {
  event.preventDefault();
  void load(element<HTMLInputElement>("file").value);
});

// For tests, and for whoever looks from the browser's console.
Object.assign(window, {
  acus: {
    get tick() { return drawn; },
    get frames() { return stage.frames; },
    get standing() { return standing; },
    get hello() { return hello; },
    get tissue() { return tissue; },
    get curves() { return plots.times; },  // s
    get span() { return plots.span; },
    force: (needle: string) => forces.get(needle),
    tip: (needle: string) => {
      const tube = needles.get(needle);
      return tube && stage.pixel(tube.point(tube.nodes - 1));
    },
    renderer: () => {
      const gl = stage.renderer.getContext(), names = gl.getExtension("WEBGL_debug_renderer_info");
      return String(gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    },
    stage,
    link,
    hands,
    // A moment (s) of the recording, drawn whole, for pictures.
    show: async (moment: number) => {
      document.body.className = "film";
      link.say({ run: false });
      const jumps = jumped;
      link.say({ seek: moment });
      const all = needles.size + (tissue ? 1 : 0);
      if (!(await waitFor(() => jumped > jumps && shapes >= all, 60))) throw new Error("no state of this moment came");
      plots.draw(true);
      const frames = (stage.draw(), stage.frames);
      if (!(await waitFor(() => stage.frames > frames, 60))) throw new Error("nothing was drawn");
    },
  },
});
show();
