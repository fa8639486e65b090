// SPDX-License-Identifier: BSD-3-Clause
// What is looked at, in the address of the page: whoever opens it again, or is sent it, sees the same.
//
//   #frame=120&eye=1.5,2,-3&target=0,0,4&colour=life&least=10&picture=right&layers=odom,-points&pick=points:812&to=keyframes:3
import { Vector3 } from "three";

const kQuiet_ms = 250;
// No map reaches as far, and the arithmetic of the graphics card ends not far beyond.
const kFarthest_m = 1e7;

export class Address {
  /** `entries` are {read(parameters), write(parameters)}, each for a part of what is looked at. */
  constructor(entries) {
    this.entries = entries;
    // What was asked for is not written over before it was read.
    this.wasRead = false;
    // Of what is going to be written.
    this.timer = null;
    window.addEventListener("hashchange", () => this.read());
  }

  /** Goes to what the address says. */
  read() {
    this.wasRead = true;
    const wanted = new URLSearchParams(window.location.hash.slice(1));
    if (window.location.hash.length <= 1) return;
    for (const entry of this.entries) {
      try {
        entry.read(wanted);
      } catch (error) {
        // One part that cannot be shown must not keep the others from being shown.
        console.warn(`the address: ${error.message}`);
      }
    }
  }

  /** Soon, since a hand that turns the map or moves the slider does so many times a second. */
  write() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.timer = null;
      if (!this.wasRead) return;
      const now = new URLSearchParams();
      for (const entry of this.entries) entry.write(now);
      const text = now.toString().replaceAll("%2C", ",").replaceAll("%3A", ":").replaceAll("%40", "@");
      // Not a step of the history: "back" leaves the page.
      window.history.replaceState(null, "", `#${text}`);
    }, kQuiet_ms);
  }
}

function triple(text) {
  const numbers = (text ?? "").split(",").map(Number);
  return numbers.length === 3 && numbers.every((x) => Math.abs(x) <= kFarthest_m) ? new Vector3(...numbers) : null;
}

function text(vector) {
  return vector.toArray().map((x) => Number(x.toPrecision(6))).join(",");
}

/** The moment. A live page that shows the newest frame goes on doing so. */
export function frameEntry(replay) {
  return {
    read: (wanted) => {
      const frame = Number(wanted.get("frame") ?? NaN);
      if (Number.isFinite(frame)) replay.go(replay.run.rowOf(frame));
    },
    write: (now) => {
      const { run, row } = replay;
      if (run?.rows && (run.facts.finished || row < run.rows - 1)) now.set("frame", run.frames.id[row]);
    },
  };
}

/** From where the map is seen: the whole, which fits windows of any size, or an eye and what it looks at. */
export function viewEntry(view) {
  return {
    read: (wanted) => {
      const [eye, target] = [triple(wanted.get("eye")), triple(wanted.get("target"))];
      if (eye && target) view.lookFrom(eye, target);
      else if (wanted.has("view")) view.lookAtAll(wanted.get("view") === "top");
    },
    write: (now) => {
      if (view.pristine) return now.set("view", view.fromAbove ? "top" : "all");
      now.set("eye", text(view.camera.position));
      now.set("target", text(view.controls.target));
    },
  };
}

/** A choice that is written where it is not `usual`; `set` gets `usual` where the address says nothing. */
export function choiceEntry(name, usual, get, set) {
  return {
    read: (wanted) => set(wanted.get(name) ?? usual),
    write: (now) => get() !== usual && now.set(name, get()),
  };
}
