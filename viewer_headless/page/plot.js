// SPDX-License-Identifier: BSD-3-Clause
// One plot: title, legend with values at the cursor, axes with units, a line at the current time of the replay.
import uPlot from "uplot";
import { element } from "./element.js";
import { themeColour } from "./colours.js";

const kHeight = 190;

function axis(label) {
  const colour = () => themeColour("muted");
  return {
    label,
    labelSize: 18,
    labelFont: "11px system-ui, sans-serif",
    font: "11px system-ui, sans-serif",
    stroke: colour,
    grid: { stroke: () => themeColour("grid"), width: 1 },
    ticks: { stroke: () => themeColour("grid"), width: 1, size: 4 },
  };
}

/** A vertical line at `now()`. */
function nowLine(now) {
  const draw = (u) => {
    const t = now();
    if (t === null || t < u.scales.x.min || t > u.scales.x.max) return;
    const x = Math.round(u.valToPos(t, "x", true));
    u.ctx.save();
    u.ctx.strokeStyle = themeColour("accent");
    u.ctx.lineWidth = window.devicePixelRatio || 1;
    u.ctx.beginPath();
    u.ctx.moveTo(x, u.bbox.top);
    u.ctx.lineTo(x, u.bbox.top + u.bbox.height);
    u.ctx.stroke();
    u.ctx.restore();
  };
  return { hooks: { draw } };
}

export class Plot {
  /**
   * spec: {title, note, unit, xLabel, range, series: [{label, colour, fill, dash, points, steps, width, own}]}; `own`:
   * numbers of a series for the legend, if they differ from the drawn ones. `link`, in numbers of the x axis: `now()`
   * returns the time to mark or null, `seek(x)` goes there, `hover(x)` reports the cursor (null: none), `zoom([low,
   * high])` requests a range, null for all.
   */
  constructor(parent, spec, data, link) {
    this.link = link;
    this.zoomed = null;
    this.figure = element("figure", { class: "plot" });
    this.figure.append(element("figcaption", {}, spec.title, element("small", {}, spec.note ?? "")));
    this.box = element("div", { class: "canvas" });
    this.figure.append(this.box);
    parent.append(this.figure);
    const options = {
      width: this.width(),
      height: kHeight,
      scales: { x: { time: false }, y: { range: spec.range } },
      axes: [{ ...axis(spec.xLabel ?? "time in s"), size: 28, labelGap: -2 }, { ...axis(spec.unit), size: 52 }],
      series: [{ label: spec.xLabel ?? "time in s", value: (_, v) => (v == null ? "–" : `${v.toFixed(2)} s`) }, ...spec.series.map((s, i) => this.serie(s, i))],
      cursor: { y: false, focus: { prox: 16 }, drag: { x: true, y: false, setScale: false, dist: 4 }, bind: { dblclick: () => () => link.zoom(null) } },
      legend: { live: true },
      plugins: [nowLine(link.now)],
      hooks: {
        setCursor: [(u) => this.visible !== undefined && link.hover(u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : null)],
        setSelect: [(u) => this.zoomTo(u)],
      },
    };
    this.own = spec.series.map((s) => s.own);
    // Counts have no unit.
    this.unit = { m: " m", deg: "°", ms: " ms", MB: " MB", "% of a core": " %" }[spec.unit] ?? "";
    this.plot = new uPlot(options, data, this.box);
    this.plot.over.addEventListener("mouseleave", () => setTimeout(() => this.showValues()));
    this.plot.over.addEventListener("click", (event) => link.seek(this.plot.posToVal(event.offsetX, "x")));
    // Requested after the size is stable, because a redraw within the notification would be notified again.
    this.observer = new ResizeObserver(() => requestAnimationFrame(() => this.resize()));
    this.observer.observe(this.figure);
    // Invisible plots are drawn later.
    this.visible = true;
    this.watcher = new IntersectionObserver((entries) => this.setVisible(entries.at(-1).isIntersecting));
    this.watcher.observe(this.figure);
  }

  /** Zooms to the dragged range. */
  zoomTo(u) {
    const { left, width } = u.select;
    if (!(width > 0)) return;
    const range = [left, left + width].map((x) => u.posToVal(x, "x"));
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.link.zoom(range);
  }

  /** Shows the range [low, high] of the x axis; null for all. */
  setZoom(range) {
    this.zoomed = range;
    const x = this.plot.data[0];
    if (!this.visible || x.length < 2) return;
    const [min, max] = range ?? [x[0], x.at(-1)];
    this.plot.setScale("x", { min, max });
    this.showValues();
  }

  /** Shows the cursor at x, like the pointer; null hides it. */
  showCursor(x) {
    if (!this.visible) return;
    const left = x === null ? -10 : this.plot.valToPos(x, "x");
    this.plot.setCursor(left >= 0 && left <= this.plot.over.clientWidth ? { left, top: 10 } : { left: -10, top: -10 }, false);
    this.showValues();
  }

  setVisible(visible) {
    this.visible = visible;
    if (!visible) return;
    const waiting = this.waiting;
    this.waiting = null;
    if (waiting) this.plot.setData(waiting, false);
    this.setZoom(this.zoomed);
    this.showValues();
  }

  serie(s, index) {
    return {
      label: s.label,
      stroke: s.colour,
      fill: s.fill,
      width: s.width ?? 1.6,
      dash: s.dash,
      points: { show: s.points === true, size: 4, stroke: s.colour, fill: s.colour },
      paths: s.points === true ? () => null : s.steps ? uPlot.paths.stepped({ align: 1 }) : undefined,
      value: (_, v, __, i) => {
        const shown = this.own[index] && i !== null ? this.own[index][i] : v;
        return shown === null || shown === undefined ? "–" : `${Number(shown.toPrecision(3))}${this.unit}`;
      },
    };
  }

  width() {
    return Math.max(220, this.box.clientWidth || this.figure.clientWidth || 400);
  }

  resize() {
    const width = this.width();
    if (Math.abs(width - this.plot.width) >= 1) this.plot.setSize({ width, height: kHeight });
  }

  /** Replaces the numbers of the same series. */
  setData(data, spec) {
    this.own = spec.series.map((s) => s.own);
    if (!this.visible) {
      this.waiting = data;
      return;
    }
    this.plot.setData(data, false);
    this.setZoom(this.zoomed);
  }

  redraw() {
    if (!this.visible) return;
    this.plot.redraw(false, true);
    this.showValues();
  }

  /** Shows in the legend the current values (or the last ones, if there is no current time), unless there is a
   * cursor. */
  showValues() {
    const { plot } = this;
    if (plot.cursor.idx !== null && plot.cursor.idx !== undefined) return;
    const t = this.link.now();
    const x = plot.data[0];
    plot.setLegend({ idx: t === null ? x.length - 1 : Math.min(x.length - 1, plot.valToIdx(t)) }, false);
  }

  destroy() {
    this.observer.disconnect();
    this.watcher.disconnect();
    this.plot.destroy();
    this.figure.remove();
  }
}
