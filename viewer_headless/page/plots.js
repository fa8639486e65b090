// All plots of the page.
import { byId, element } from "./element.js";
import { Plot } from "./plot.js";
import { plotsOf } from "./plot_data.js";

export class Plots {
  constructor(seek) {
    this.parent = byId("plots");
    this.seek = seek;
    this.plots = new Map();
    this.now = null;
  }

  /** Draws the plots of the run; those that are there and have the same series only get new data. */
  setRun(run) {
    const wanted = plotsOf(run);
    const shape = JSON.stringify(wanted.map((p) => [p.key, p.spec.series.map((s) => s.label)]));
    if (shape === this.shape) {
      for (const { key, spec, data } of wanted) this.plots.get(key).setData(data, spec);
      return this.redraw();
    }
    this.shape = shape;
    for (const plot of this.plots.values()) plot.destroy();
    this.plots.clear();
    if (!this.parent.querySelector("h2")) this.parent.append(element("h2", {}, "Figures"));
    for (const { key, spec, data, wall } of wanted) {
      const plot = new Plot(this.parent, spec, data, () => (wall ? null : this.now), wall ? null : this.seek);
      plot.figure.dataset.plot = key;
      this.plots.set(key, plot);
    }
    this.redraw();
  }

  setNow(t) {
    this.now = t;
    if (this.pending) return;
    this.pending = true;
    // The picture and the map go first while a replay runs.
    setTimeout(() => {
      this.pending = false;
      this.redraw();
    }, 60);
  }

  redraw() {
    for (const plot of this.plots.values()) plot.redraw();
  }
}
