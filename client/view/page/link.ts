// SPDX-License-Identifier: MIT
// The connection to the gateway: it says the token first, hands on what the server says, and connects again by itself.
import { decode, encode } from "./vendor/libraries.js";
import type { Choices, Message, Standing } from "./messages.js";

export interface Listener {
  message(message: Message): void;
  standing(standing: Standing): void;
  choices(choices: Choices): void;
  notice(words: string): void;
  jumped(): void; // another moment of a recording: what was told is void
  lost(why: string): void; // no connection to the gateway
  damaged(why: string): void; // a frame that cannot be read was left out
}

const answerTypes = ["done", "holding", "snapshot_reply"];

export class Link {
  private socket: WebSocket | null = null;
  private seq = 0;
  wantsToDrive = false; // what was asked last: `standing` follows a moment later
  private waiting = new Map<number, { type: string; resolve: (answer: Message) => void }>();

  constructor(readonly token: string, private listener: Listener) {
    this.connect();
    // A browser may keep a page that was left, to show it again: it must not hold the needle meanwhile.
    addEventListener("pagehide", () => {
      const socket = this.socket;
      this.socket = null;
      socket?.close();
    });
    addEventListener("pageshow", (event) => event.persisted && this.connect());
  }

  private connect(): void {
    const socket = new WebSocket(`ws://${location.host}/link`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => socket.send(JSON.stringify({ token: this.token }));
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => this.take(event.data);
    socket.onclose = (event: CloseEvent) => {
      if (socket !== this.socket) return;
      for (const { resolve } of this.waiting.values())
        resolve({ type: "error", code: "gone", message: "the connection ended before the answer" });
      this.waiting.clear();
      this.wantsToDrive = false;
      this.listener.lost(event.reason || "the gateway does not answer");
      if (event.code !== 1008) setTimeout(() => this.connect(), 1000); // 1008: it refuses
    };
    this.socket = socket;
  }

  private take(data: string | ArrayBuffer): void {
    try {
      if (typeof data === "string") {
        const words = JSON.parse(data) as Standing | Choices | { beat: number } | { notice: string } | { jump: number };
        if ("beat" in words) return this.put(data); // all before it has been taken in
        if ("notice" in words) return this.listener.notice(words.notice);
        if ("jump" in words) return this.listener.jumped();
        if ("scenes" in words) return this.listener.choices(words);
        return this.listener.standing(words);
      }
      const message = decode(new Uint8Array(data)) as Message & { seq?: number };
      if (typeof message !== "object" || message === null || typeof message.type !== "string")
        throw new Error("expected a map with a type");
      const waiting = message.seq === undefined ? undefined : this.waiting.get(message.seq);
      // Poses are counted like requests: an error says which it is about.
      const answers = message.type === "error" ? message.rejected === waiting?.type : answerTypes.includes(message.type);
      if (waiting && answers) {
        this.waiting.delete(message.seq as number);
        waiting.resolve(message);
      }
      this.listener.message(message);
    } catch (error) {
      this.listener.damaged(String(error));
    }
  }

  private put(bytes: string | Uint8Array<ArrayBuffer>): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(bytes);
  }

  // To the gateway (client/view/gateway.h).
  say(words: object): void {
    this.put(JSON.stringify(words));
  }

  drive(wanted: boolean): void {
    this.wantsToDrive = wanted;
    this.say({ drive: wanted });
  }

  // A stream, which has no answer. Numbers that are to be floats must not be integers in msgpack: the server takes both.
  send(type: string, fields: object): void {
    this.put(encode({ v: 2, type, ...fields }) as Uint8Array<ArrayBuffer>);
  }

  // Only the page that drives gets answers.
  request(type: string, fields: object = {}): Promise<Message> {
    const seq = ++this.seq;
    return new Promise((resolve) => {
      this.waiting.set(seq, { type, resolve });
      this.send(type, { seq, ...fields });
    });
  }
}
