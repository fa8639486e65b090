// SPDX-License-Identifier: BSD-3-Clause
// Keeps the current view in the address of the page, so that the address shows the same view when it is opened again.
//
//   #frame=120&eye=1.5,2,-3&target=0,0,4&colour=life&least=10&picture=right&layers=odom,-points&pick=points:812&to=keyframes:3
import { Vector3 } from "three";

const kQuiet_ms = 250;
// Larger than any map, and near the limit of the arithmetic of the graphics card.
const kFarthest_m = 1e7;

export class Address {
  /** `entries` are {read(parameters), write(parameters)}, each for a part of the view. */
  constructor(entries) {
    this.entries = entries;
    // The address is not overwritten before it was read.
    this.wasRead = false;
    // Parameters of the next address.
    this.timer = null;
    window.addEventListener("hashchange", () => this.read());
  }

  /** Shows the view in the address. */
  read() {
    this.wasRead = true;
    const wanted = new URLSearchParams(window.location.hash.slice(1));
    if (window.location.hash.length <= 1) return;
    for (const entry of this.entries) {
      try {
        entry.read(wanted);
      } catch (error) {
        // A part that cannot be shown must not prevent the others.
        console.warn(`the address: ${error.message}`);
      }
    }
  }

  /** Writes the address after a delay, because turning the map or moving the slider changes it many times a second. */
  write() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.timer = null;
      if (!this.wasRead) return;
      const now = new URLSearchParams();
      for (const entry of this.entries) entry.write(now);
      const text = now.toString().replaceAll("%2C", ",").replaceAll("%3A", ":").replaceAll("%40", "@");
      // Replaces the entry of the browser's history: "back" leaves the page.
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

/** The current frame. A live page that shows the newest frame continues to do so. */
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

/** The view of the map: the whole map, which fits windows of any size, or an eye and its target. */
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

/** A choice that is written if it is not `usual`; `set` gets `usual` if the address does not contain it. */
export function choiceEntry(name, usual, get, set) {
  return {
    read: (wanted) => set(wanted.get(name) ?? usual),
    write: (now) => get() !== usual && now.set(name, get()),
  };
}
