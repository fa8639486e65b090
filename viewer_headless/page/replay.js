// SPDX-License-Identifier: BSD-3-Clause
// The time slider and the replay.
import { byId } from "./element.js";
import { seconds } from "./format.js";

export class Replay {
  /** `changed(row)` is called for each new frame. */
  constructor(changed) {
    this.changed = changed;
    this.slider = byId("time");
    this.button = byId("play");
    this.row = 0;
    this.playing = false;
    this.slider.addEventListener("input", () => this.go(Number(this.slider.value)));
    this.button.addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    // The focused element keeps its own keys; the time slider steps by itself.
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select, textarea, #order")) return;
    if (byId("help").open) return;
    const control = event.target.closest("input, button, tr");
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (event.key === " " && (!control || control === this.slider)) {
      event.preventDefault();
      if (!event.repeat) this.button.click();
    } else if (step && (!control || control.matches("button, [type=checkbox]"))) {
      event.preventDefault();
      this.go(this.row + (event.shiftKey ? 10 : 1) * step);
    }
  }

  /** Stays at the end if it was at the end, so that it follows a live run. */
  setRun(run) {
    const atEnd = !this.run || this.row >= Number(this.slider.max);
    this.run = run;
    this.slider.max = Math.max(0, run.rows - 1);
    this.go(atEnd && !this.playing ? run.rows - 1 : this.row, true);
  }

  go(row, quiet = false) {
    if (!this.run?.rows) return;
    const next = Math.min(this.run.rows - 1, Math.max(0, Math.round(row)));
    if (next === this.row && quiet && this.started) return this.tell();
    this.started = true;
    this.row = next;
    this.slider.value = next;
    this.tell();
    this.changed(next);
  }

  tell() {
    const t = this.run.frames.t_s[this.row];
    byId("clock").textContent = `${seconds(t)} · frame ${this.run.frames.id[this.row]}`;
    this.slider.setAttribute("aria-valuetext", byId("clock").textContent);
  }

  play() {
    if (!this.run?.rows) return;
    if (this.row >= this.run.rows - 1) this.go(0);
    this.playing = true;
    this.button.textContent = "❚❚";
    this.button.setAttribute("aria-label", "Pause");
    this.t_s = this.run.frames.t_s[this.row];
    this.last = null;
    requestAnimationFrame((now) => this.step(now));
  }

  pause() {
    this.playing = false;
    this.button.textContent = "▶";
    this.button.setAttribute("aria-label", "Play");
  }

  step(now) {
    if (!this.playing) return;
    const dt_s = this.last === null ? 0 : Math.min(0.25, (now - this.last) / 1000);
    this.last = now;
    this.t_s += dt_s * Number(byId("speed").value);
    const row = this.run.rowAt(this.t_s);
    if (row !== this.row) this.go(row);
    if (this.row >= this.run.rows - 1) return this.pause();
    requestAnimationFrame((next) => this.step(next));
  }
}
