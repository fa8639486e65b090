// SPDX-License-Identifier: BSD-3-Clause
// A keyframe or landmark that was clicked: who observes it, as rays, and the keyframes that do; and what is known of it in words.
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments } from "three";
import { themeColour } from "./colours.js";
import { byId, element } from "./element.js";
import { FatLine } from "./fat_line.js";
import { count, metres } from "./format.js";
import { frustumOf, kFrustumEdges, putFrustum } from "./keyframes.js";
import { unpackSigma } from "./observers.js";

const kNames = { keyframes: "Keyframe", points: "Point", segments: "Segment" };
const kWidths = { points: 3, segments: 6 };
const kColumn = { points: "p", segments: "pq" };
// Keyframes that are named one by one.
const kMostNamed = 12;

/** Rows of the landmarks of a type that a keyframe observes. */
function landmarksOf(run, type, keyframe) {
  const observers = run.observersOf(type);
  const rows = [];
  for (let i = 0; observers && i < observers.ids.length; ++i) {
    for (let k = observers.starts[i]; k < observers.starts[i + 1]; ++k) if (observers.rows[k] === keyframe) rows.push(i);
  }
  return rows;
}

/** Ids of the rows; none of landmarks where they were left out. */
function idsOf(run, type) {
  return type === "keyframes" ? Array.from(run.map?.keyframes.id ?? []) : run.observersOf(type)?.ids ?? [];
}

/** The middle of a landmark, or the centre of a keyframe. */
function middleOf(run, { type, row }) {
  if (type !== "segments") return Array.from((run.map[type].p).subarray(3 * row, 3 * row + 3));
  const ends = run.map.segments.pq.subarray(6 * row, 6 * row + 6);
  return [0, 1, 2].map((k) => 0.5 * (ends[k] + ends[k + 3]));
}

/**
 * Of what was picked: `observers`, rows of the keyframes that observe it (of a keyframe: those that share landmarks with it);
 * `rays` between a keyframe and a landmark, as pairs of positions; and how many landmarks of each type a keyframe observes.
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

export class Selection {
  constructor(world) {
    this.rays = new FatLine(world, "picked", 1.2, { opacity: 0.55, order: 7 });
    this.mark = new FatLine(world, "picked", 6, { order: 9 });
    this.measure = new FatLine(world, "picked", 2.4, { order: 9 });
    this.frusta = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ depthTest: false, transparent: true }));
    this.frusta.frustumCulled = false;
    this.frusta.renderOrder = 8;
    world.add(this.frusta);
    this.picked = null;
    this.goTo = () => {};
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

  /** Rows of another map mean something else: what was picked is looked for by its id. */
  setRun(run, size) {
    this.size = size;
    if (run.map === this.map) return;
    this.map = run.map;
    if (!this.picked) return;
    const row = idsOf(run, this.picked.type).indexOf(this.id);
    this.choose(run, row < 0 ? null : { type: this.picked.type, row });
  }

  /** `picked` as the picker gives it; null for nothing. */
  choose(run, picked) {
    this.picked = picked;
    this.other = null;
    this.id = picked && run.map ? idsOf(run, picked.type)[picked.row] : undefined;
    this.found = picked && run.map ? observationsOf(run, picked) : null;
    if (this.found) this.draw(run);
    this.show();
    this.describe(run);
  }

  /** Draws a line to another thing that was picked, and says how long it is; null takes it away. */
  measureTo(run, other) {
    this.other = this.found ? other : null;
    if (this.other) this.measure.setPairs([...middleOf(run, this.picked), ...middleOf(run, this.other)]);
    this.show();
    this.describe(run);
  }

  draw(run) {
    const { type, row } = this.picked;
    this.rays.setPairs(this.found.rays);
    // A thousand rays of a keyframe must not hide what they lead to.
    this.rays.material.opacity = Math.min(0.6, Math.max(0.06, 30 / this.rays.n));
    this.drawFrusta(run, type === "keyframes" ? [row, ...this.found.observers] : this.found.observers);
    const ends = type === "segments" ? [...run.map.segments.pq.subarray(6 * row, 6 * row + 6)] : null;
    // A dot is a line of no length to speak of with round ends.
    const p = middleOf(run, this.picked);
    this.mark.setPairs(ends ?? [...p, p[0] + 1e-4 * this.size, p[1], p[2]]);
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
  }

  show() {
    const chosen = !!this.found;
    this.rays.visible = chosen;
    this.mark.visible = chosen;
    this.measure.visible = chosen && !!this.other;
    this.frusta.visible = chosen;
  }

  /** The small box. */
  describe(run) {
    const box = byId("picked");
    box.hidden = !this.found;
    if (!this.found) return box.replaceChildren();
    const rows = this.picked.type === "keyframes" ? this.ofKeyframe(run) : this.ofLandmark(run);
    if (this.other) rows.push(this.distance(run));
    box.replaceChildren(
      element("button", { type: "button", class: "close", "aria-label": "Close", onclick: () => this.clear(run) }, "×"),
      element("h3", {}, `${kNames[this.picked.type]} ${this.id ?? ""}`),
      element("dl", {}, ...rows.flatMap(([name, ...value]) => [element("dt", {}, name), element("dd", {}, ...value)])));
  }

  clear(run) {
    this.choose(run, null);
    this.changed?.();
  }

  ofKeyframe(run) {
    const { row } = this.picked;
    const frame = run.map.keyframes.frame[row];
    const { seen, observers } = this.found;
    const known = run.packedObservers !== null;
    return [
      ["frame", this.link(run, frame)],
      ["observes", known ? `${count(seen.points)} points, ${count(seen.segments)} segments` : "not stored (long run)"],
      ["covisible", `${count(observers.length)} keyframes`],
      ["sigma", metres(run.map.keyframes.sigma_m?.[row])],
    ];
  }

  ofLandmark(run) {
    const { type, row } = this.picked;
    const table = run.map[type];
    const frames = this.found.observers.map((k) => run.map.keyframes.frame[k]);
    const named = frames.slice(0, kMostNamed).map((frame) => this.link(run, frame));
    const p = middleOf(run, this.picked);
    const up = run.map.vertical.up;
    const ends = type === "segments" ? table[kColumn[type]].subarray(row * kWidths[type], (row + 1) * kWidths[type]) : null;
    return [
      ["observed by", `${count(table.observations[row])}${table.observations[row] === 255 ? " and more" : ""} keyframes`],
      ["in frames", ...(run.packedObservers ? named : ["not stored (long run)"]), frames.length > kMostNamed ? ` and ${frames.length - kMostNamed} more` : ""],
      ["sigma", `${metres(unpackSigma(table.sigma?.[row]))}${ends ? " across" : ""}`],
      ["height", metres(up[0] * p[0] + up[1] * p[1] + up[2] * p[2])],
      ends && ["length", metres(Math.hypot(ends[3] - ends[0], ends[4] - ends[1], ends[5] - ends[2]))],
    ].filter(Boolean);
  }

  distance(run) {
    const [p, q] = [middleOf(run, this.picked), middleOf(run, this.other)];
    const other = `${kNames[this.other.type].toLowerCase()} ${idsOf(run, this.other.type)[this.other.row] ?? ""}`;
    return ["distance", `${metres(Math.hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]))} to ${other}`];
  }

  link(run, frame) {
    return element("button", { type: "button", class: "link", onclick: () => this.goTo(frame) }, `${frame}`);
  }
}
