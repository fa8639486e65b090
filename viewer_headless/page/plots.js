// SPDX-License-Identifier: BSD-3-Clause
// All plots of the page: one cursor, one zoom, one current time. Plots over the time of the host are linked by a clock.
import { byId, element } from "./element.js";
import { Plot } from "./plot.js";
import { plotsOf } from "./plot_data.js";
import { WallClock } from "./wall_clock.js";

/** Plots about the result; the others are folded. */
const kForUsers = new Set(["error", "rotation", "tracked"]);

export class Plots {
  constructor(seek) {
    this.parent = byId("plots");
    this.seek = seek;
    this.plots = new Map();
    this.now = null;
    /** Shown range of times of the recording; null for all. */
    this.zoomed = null;
  }

  /** Draws the plots of the run; existing ones with the same series only get new data. */
  setRun(run) {
    this.clock = new WallClock(run);
    const wanted = plotsOf(run);
    const shape = JSON.stringify(wanted.map((p) => [p.key, p.spec.series.map((s) => s.label)]));
    if (shape === this.shape) {
      for (const { key, spec, data } of wanted) this.plots.get(key).setData(data, spec);
      return this.redraw();
    }
    this.shape = shape;
    for (const plot of this.plots.values()) plot.destroy();
    this.plots.clear();
    if (!this.folded) this.addHead();
    for (const { key, spec, data, wall } of wanted) {
      const plot = new Plot(kForUsers.has(key) ? this.parent : this.folded, spec, data, this.linkOf(key, wall));
      plot.figure.dataset.plot = key;
      this.plots.set(key, plot);
    }
    this.parent.append(this.folded.parentElement);
    this.zoom(this.zoomed);
  }

  addHead() {
    this.whole = element("button", { type: "button", id: "zoom-out", hidden: true, onclick: () => this.zoom(null) }, "Whole run");
    this.parent.append(element("h2", {}, "Figures",
      element("small", {}, "drag to zoom all plots, double-click for the whole run, click to go to a time"), this.whole));
    this.folded = element("div", { class: "plots" });
    this.parent.append(element("details", { id: "more-plots" },
      element("summary", {}, "For developers: keyframe decisions, stages, queues, lost messages, processor and memory"), this.folded));
  }

  /** Connects a plot to the others, in the times of its own axis. */
  linkOf(key, wall) {
    const toTime = (x) => (wall ? this.clock.timeAt(x) : x);
    const toAxis = (t) => (t === null || !wall ? t : this.clock.wallAt(t));
    return {
      toAxis,
      now: () => toAxis(this.now),
      seek: (x) => toTime(x) !== null && this.seek(toTime(x)),
      hover: (x) => this.hover(key, x === null ? null : toTime(x)),
      zoom: (range) => this.zoom(range && range.map(toTime)),
    };
  }

  onAxis(plot, range) {
    const ends = range?.map((t) => plot.link.toAxis(t));
    return ends && ends.every((x) => x !== null) && ends[1] > ends[0] ? ends : null;
  }

  /** Moves the cursors of all plots but `from` to t. */
  hover(from, t) {
    for (const [key, plot] of this.plots) if (key !== from) plot.showCursor(t === null ? null : plot.link.toAxis(t));
  }

  /** Shows [from, to] in all plots; null for the whole run. */
  zoom(range) {
    this.zoomed = range && range[1] > range[0] ? range : null;
    if (this.whole) this.whole.hidden = !this.zoomed;
    for (const plot of this.plots.values()) plot.setZoom(this.onAxis(plot, this.zoomed));
  }

  setNow(t) {
    this.now = t;
    if (this.pending) return;
    this.pending = true;
    // The picture and the map have priority during a replay.
    setTimeout(() => {
      this.pending = false;
      this.redraw();
    }, 60);
  }

  redraw() {
    for (const plot of this.plots.values()) plot.redraw();
  }
}
