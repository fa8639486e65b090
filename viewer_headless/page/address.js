// SPDX-License-Identifier: BSD-3-Clause
// What is looked at, in the address of the page: whoever opens it again, or is sent it, sees the same.
//
//   #frame=120&eye=1.5,2,-3&target=0,0,4
import { Vector3 } from "three";

const kQuiet_ms = 250;

function triple(text) {
  const numbers = (text ?? "").split(",").map(Number);
  return numbers.length === 3 && numbers.every(Number.isFinite) ? new Vector3(...numbers) : null;
}

function text(vector) {
  return vector.toArray().map((x) => Number(x.toPrecision(6))).join(",");
}

export class Address {
  /** `view` may be null (no WebGL): then the address holds the frame alone. */
  constructor(view, replay) {
    this.view = view;
    this.replay = replay;
    window.addEventListener("hashchange", () => this.read());
  }

  /** Goes to what the address says; what is missing or no number stays as it is. */
  read() {
    const wanted = new URLSearchParams(window.location.hash.slice(1));
    const frame = Number(wanted.get("frame") ?? NaN);
    if (Number.isFinite(frame)) this.replay.go(this.replay.run.rowOf(frame));
    const [eye, target] = [triple(wanted.get("eye")), triple(wanted.get("target"))];
    if (this.view && eye && target) this.view.lookFrom(eye, target);
  }

  /** Soon, since a hand that turns the map or moves the slider does so many times a second. */
  write() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      const now = new URLSearchParams();
      now.set("frame", this.replay.run.frames.id[this.replay.row]);
      if (this.view) {
        now.set("eye", text(this.view.camera.position));
        now.set("target", text(this.view.controls.target));
      }
      // Not a step of the history: "back" leaves the page.
      window.history.replaceState(null, "", `#${now.toString().replaceAll("%2C", ",")}`);
    }, kQuiet_ms);
  }
}
