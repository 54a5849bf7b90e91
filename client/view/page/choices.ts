// SPDX-License-Identifier: MIT
// What the gateway offers: scenes beside the first, recorded motions, and recordings to take home.
import type { Choices } from "./messages.js";
import { element } from "./panel.js";

let offered: Choices = { scenes: {}, motions: [], records: false };
let shown = ""; // file

const select = (id: string): HTMLSelectElement => element<HTMLSelectElement>(id);

export function offer(choices: Choices): void {
  offered = choices;
  shown = "";
  const scenes = Object.keys(offered.scenes);
  for (const [id, names] of Object.entries({ scenes, motions: offered.motions }))
    select(id).replaceChildren(...names.map((name) => new Option(name.replaceAll("_", " "), name)));
  element("choices").hidden = scenes.length === 0;
  element("record").hidden = !offered.records;
}

// The scene that runs, and the motion that is made for it.
export function showChoice(file: string): void {
  if (file === shown) return;
  shown = file;
  const scene = file.replace(/\.yaml$/, "");
  select("scenes").value = scene;
  select("motions").value = offered.scenes[scene] ?? "";
}

export const chosenScene = (): string => select("scenes").value;
export const chosenMotion = (): string => select("motions").value;

// A name for a recording of the scene that runs, with the time.
export function recordingName(): string {
  const time = new Date().toISOString().slice(0, 19).replaceAll(":", "-");
  return `${shown.replace(/\.yaml$/, "").replace(/[^A-Za-z0-9_-]/g, "_").slice(0, 60) || "run"}-${time}.acus`;
}

const SAVING = 60000; // ms that the browser has to save what it was given

// Lets the browser save it. The server's file goes once that is done; if the page goes before, it stays.
export async function takeHome(name: string, token: string): Promise<boolean> {
  const place = `/recordings/${name}`, headers = { Authorization: `Bearer ${token}` };
  const link = document.createElement("a");
  try {
    const answer = await fetch(place, { headers });
    if (!answer.ok) return false;
    link.href = URL.createObjectURL(await answer.blob());
  } catch {
    return false;
  }
  link.download = name;
  link.click();
  setTimeout(() => {
    URL.revokeObjectURL(link.href);
    void fetch(place, { method: "DELETE", headers });
  }, SAVING);
  return true;
}
