// SPDX-License-Identifier: BSD-3-Clause
// A selected keyframe or landmark: its observations as rays, the observing keyframes, and a table of its data.
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Matrix4, Vector3 } from "three";
import { themeColour } from "./colours.js";
import { byId, element } from "./element.js";
import { FatLine } from "./fat_line.js";
import { counted, metres, observedBy } from "./format.js";
import { frustumOf, kFrustumEdges, putFrustum } from "./keyframes.js";
import { unpackSigma } from "./observers.js";

const kNames = { keyframes: "Keyframe", points: "Point", segments: "Segment" };
// Largest number of keyframes that are listed.
const kMostNamed = 12;

/** Returns the rows of the landmarks of a type that a keyframe observes. */
function landmarksOf(run, type, keyframe) {
  const observers = run.observersOf(type);
  const rows = [];
  for (let i = 0; observers && i < observers.ids.length; ++i) {
    for (let k = observers.starts[i]; k < observers.starts[i + 1]; ++k) if (observers.rows[k] === keyframe) rows.push(i);
  }
  return rows;
}

/** Returns the ids of the rows. */
function idsOf(run, type) {
  return type === "keyframes" ? Array.from(run.map?.keyframes.id ?? []) : run.observersOf(type)?.ids ?? [];
}

/** Returns the run of a picked object: the page's own, or another one in it. */
function runOf(run, { of = 0 }) {
  return of ? run.others[of - 1] : run;
}

/** Converts a position from the map of a run to that of the page's own. */
function placed(run, p) {
  return run.transform ? new Vector3(...p).applyMatrix4(run.transform).toArray() : Array.from(p);
}

/** Returns both ends of a segment. */
function endsOf(run, row) {
  const { pq } = run.map.segments;
  return [...placed(run, pq.subarray(6 * row, 6 * row + 3)), ...placed(run, pq.subarray(6 * row + 3, 6 * row + 6))];
}

/** Returns the middle of a landmark, or the centre of a keyframe, of the run. */
function middleOf(run, { type, row }) {
  if (type !== "segments") return placed(run, run.map[type].p.subarray(3 * row, 3 * row + 3));
  const ends = endsOf(run, row);
  return [0, 1, 2].map((k) => 0.5 * (ends[k] + ends[k + 3]));
}

/**
 * Returns for a picked object: `observers`, rows of the keyframes that observe it (for a keyframe: that share
 * landmarks); `rays` between a keyframe and a landmark, as pairs of positions; and the numbers of landmarks of each
 * type observed.
 */
export function observationsOf(run, picked) {
  const { type, row } = picked;
  const rays = [];
  if (type !== "keyframes") {
    const packed = run.observersOf(type);
    const observers = packed ? packed.rows.slice(packed.starts[row], packed.starts[row + 1]) : [];
    for (const k of observers) rays.push(...middleOf(run, { type: "keyframes", row: k }), ...middleOf(run, picked));
    return { observers, rays };
  }
  const { ab } = run.map.edges;
  const observers = [];
  for (let i = 0; i + 1 < (ab?.length ?? 0); i += 2) {
    if (ab[i] === row) observers.push(ab[i + 1]);
    if (ab[i + 1] === row) observers.push(ab[i]);
  }
  const seen = { points: landmarksOf(run, "points", row), segments: landmarksOf(run, "segments", row) };
  for (const landmark of ["points", "segments"]) {
    for (const i of seen[landmark]) rays.push(...middleOf(run, picked), ...middleOf(run, { type: landmark, row: i }));
  }
  return { observers, rays, seen: { points: seen.points.length, segments: seen.segments.length } };
}

const isSame = (a, b) => a.type === b?.type && a.row === b.row && (a.of ?? 0) === (b.of ?? 0);

export class Selection {
  constructor(world) {
    this.rays = new FatLine(world, "picked", 1.2, { opacity: 0.55, order: 7 });
    this.mark = new FatLine(world, "picked", 6, { order: 9 });
    this.measure = new FatLine(world, "picked", 2.4, { order: 9 });
    this.frusta = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ depthTest: false, transparent: true }));
    this.frusta.frustumCulled = false;
    this.frusta.renderOrder = 8;
    world.add(this.frusta);
    this.frusta.matrixAutoUpdate = false;
    this.picked = null;
    this.label = byId("measured");
    this.goTo = () => {};
    this.close = () => {};
    this.changed = () => {};
    this.show();
  }

  retheme() {
    this.rays.retheme();
    this.mark.retheme();
    this.measure.retheme();
    this.frusta.material.color.set(themeColour("picked"));
  }

  setResolution(width, height) {
    this.rays.setResolution(width, height);
    this.mark.setResolution(width, height);
    this.measure.setResolution(width, height);
  }

  /** Rows of another map have another meaning: the picked object is found by its id. */
  setRun(run, size) {
    this.size = size;
    if (run.map === this.map) return;
    this.map = run.map;
    const { picked, other, id, otherId } = this;
    if (!picked) return;
    const now = this.find(run, picked.type, id, picked.of);
    this.choose(run, now);
    if (now && other) this.measureTo(run, this.find(run, other.type, otherId, other.of));
  }

  /** Returns the object with an id, like the picker; null if it does not exist. */
  find(run, type, id, of = 0) {
    const row = idsOf(runOf(run, { of }), type).indexOf(id);
    return row < 0 ? null : { type, row, of };
  }

  idOf(run, picked) {
    return picked && run.map ? idsOf(runOf(run, picked), picked.type)[picked.row] : undefined;
  }

  /** `picked` is a result of the picker; null for nothing. */
  choose(run, picked) {
    this.picked = picked;
    this.other = null;
    this.id = this.idOf(run, picked);
    this.found = picked && run.map ? observationsOf(runOf(run, picked), picked) : null;
    if (this.found) this.draw(run);
    this.show();
    this.describe(run);
    this.changed();
  }

  /** Draws a line to another picked object with its length; null or the same object removes it. */
  measureTo(run, other) {
    this.other = this.found && !isSame(this.picked, other) ? other : null;
    this.otherId = this.idOf(run, this.other);
    if (this.other) {
      this.measured = [middleOf(runOf(run, this.picked), this.picked), middleOf(runOf(run, this.other), this.other)];
      this.measure.setPairs(this.measured.flat());
      this.label.textContent = metres(this.length());
    }
    this.show();
    this.describe(run);
    this.changed();
  }

  length() {
    const [p, q] = this.measured;
    return Math.hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]);
  }

  /** Returns the position of the picked object in the map; null without one. */
  placeOf(run, picked) {
    return picked && middleOf(runOf(run, picked), picked);
  }

  /** Places the length beside the middle of the measured line if that is visible. */
  putLabel(picker) {
    const at = this.measure.object.visible && picker.pixelOf([0, 1, 2].map((k) => 0.5 * (this.measured[0][k] + this.measured[1][k])));
    this.label.hidden = !at;
    if (at) this.label.style.translate = `${at[0].toFixed(1)}px ${at[1].toFixed(1)}px`;
  }

  /** Returns the selection for the address: "points:812", for another run "points:812@1"; null without one. */
  textOf(picked, id) {
    return picked && id !== undefined ? `${picked.type}:${id}${picked.of ? `@${picked.of}` : ""}` : null;
  }

  /** Returns the object of such a text; null if it does not exist (yet). */
  parse(run, text) {
    const [, type, id, of] = /^(keyframes|points|segments):(\d+)(?:@(\d+))?$/.exec(text ?? "") ?? [];
    return type && run.map && (!of || run.others?.[of - 1]) ? this.find(run, type, Number(id), Number(of ?? 0)) : null;
  }

  draw(run) {
    const { type, row } = this.picked;
    const of = runOf(run, this.picked);
    this.rays.setPairs(this.found.rays);
    // A thousand rays of a keyframe must not hide their landmarks.
    this.rays.material.opacity = Math.min(0.6, Math.max(0.06, 30 / this.rays.n));
    this.drawFrusta(of, type === "keyframes" ? [row, ...this.found.observers] : this.found.observers);
    // A dot is a very short line with round ends.
    const p = middleOf(of, this.picked);
    this.mark.setPairs(type === "segments" ? endsOf(of, row) : [...p, p[0] + 1e-4 * this.size, p[1], p[2]]);
  }

  drawFrusta(run, rows) {
    const { p, q } = run.map.keyframes;
    const corners = frustumOf(run.facts.camera);
    const vertices = new Float32Array(rows.length * kFrustumEdges.length * 3);
    let at = 0;
    for (const k of rows) at = putFrustum(corners, 1.25 * this.size / 45, p.subarray(3 * k, 3 * k + 3), q.subarray(4 * k, 4 * k + 4), vertices, at);
    this.frusta.geometry.dispose();
    this.frusta.geometry = new BufferGeometry();
    this.frusta.geometry.setAttribute("position", new BufferAttribute(vertices, 3));
    this.frusta.matrix.copy(run.transform ?? new Matrix4());
    this.frusta.matrixWorldNeedsUpdate = true;
  }

  show() {
    const chosen = !!this.found;
    this.rays.visible = chosen;
    this.mark.visible = chosen;
    this.measure.visible = chosen && !!this.other;
    this.frusta.visible = chosen;
  }

  /** Fills the small box. */
  describe(run) {
    const box = byId("picked");
    box.hidden = !this.found;
    if (!this.found) return box.replaceChildren();
    const of = runOf(run, this.picked);
    const rows = this.picked.type === "keyframes" ? this.ofKeyframe(of) : this.ofLandmark(of, run.map.vertical.up);
    if (this.other) rows.push(this.distance(run));
    box.replaceChildren(
      element("button", { type: "button", class: "close", "aria-label": "Close", onclick: () => this.close() }, "×"),
      element("h3", {}, `${kNames[this.picked.type]} ${this.id ?? ""}`, of.label ? element("small", {}, of.label) : null),
      element("dl", {}, ...rows.flatMap(([name, ...value]) => [element("dt", {}, name), element("dd", {}, ...value)])));
  }

  ofKeyframe(run) {
    const { row } = this.picked;
    const frame = run.map.keyframes.frame[row];
    const { seen, observers } = this.found;
    return [
      ["frame", this.link(run, frame)],
      ["observes", run.observersKnown ? `${counted(seen.points, "point")}, ${counted(seen.segments, "segment")}` : "not stored (long run)"],
      ["covisible", counted(observers.length, "keyframe")],
      ["sigma", metres(run.map.keyframes.sigma_m?.[row])],
    ];
  }

  ofLandmark(run, up) {
    const { type, row } = this.picked;
    const table = run.map[type];
    const frames = this.found.observers.map((k) => run.map.keyframes.frame[k]);
    const named = frames.slice(0, kMostNamed).map((frame) => this.link(run, frame));
    const p = middleOf(run, this.picked);
    const ends = type === "segments" ? endsOf(run, row) : null;
    return [
      ["observed by", observedBy(table.observations[row])],
      ["in frames", ...(run.observersKnown ? named : ["not stored (long run)"]), frames.length > kMostNamed ? ` and ${frames.length - kMostNamed} more` : ""],
      table.life && ["seen over", counted(table.life[row], "frame")],
      ["sigma", `${metres(unpackSigma(table.sigma?.[row]))}${ends ? " across" : ""}`],
      ["height", metres(up[0] * p[0] + up[1] * p[1] + up[2] * p[2])],
      ends && ["length", metres(Math.hypot(ends[3] - ends[0], ends[4] - ends[1], ends[5] - ends[2]))],
    ].filter(Boolean);
  }

  distance(run) {
    const label = runOf(run, this.other).label;
    const other = `${kNames[this.other.type].toLowerCase()} ${this.otherId ?? ""}${label ? ` of ${label}` : ""}`;
    return ["distance", `${metres(this.length())} to ${other}`];
  }

  link(run, frame) {
    return element("button", { type: "button", class: "link", onclick: () => this.goTo(frame) }, `${frame}`);
  }
}
