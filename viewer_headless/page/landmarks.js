// SPDX-License-Identifier: BSD-3-Clause
// Points and segments of the map, one geometry each. In the order of their first observation, so that each time of the
// run is a range to draw.
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Points, ShaderMaterial } from "three";
import { ramp, scales } from "./colours.js";
import { countUpTo } from "./data.js";
import { quantiles } from "./format.js";

const kVertex = `
  attribute vec3 tint;
  varying vec3 vTint;
  uniform float size;
  uniform float pixels;
  void main() {
    vTint = tint;
    vec4 p = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * p;
    gl_PointSize = clamp(size * pixels / max(1e-6, -p.z), 2.2 * pixels, 5.5 * pixels);
  }`;
const kFragment = `
  varying vec3 vTint;
  void main() {
    vec2 d = gl_PointCoord - 0.5;
    if (dot(d, d) > 0.25) discard;
    gl_FragColor = vec4(vTint, 1.0);
  }`;
const kTints = 256;

/** Returns `rows` of `width` numbers in a new order. */
function reorder(values, width, order) {
  const result = new values.constructor(order.length * width);
  order.forEach((row, i) => {
    for (let k = 0; k < width; ++k) result[i * width + k] = values[row * width + k];
  });
  return result;
}

/** The landmarks of a table in the order of their first observation. */
export class LandmarkRows {
  constructor(table, name, width) {
    const n = table.seen.length;
    this.columns = { seen: table.seen, observations: table.observations ?? new Uint8Array(n), life: table.life ?? new Uint16Array(n) };
    this.positions = table[name];
    this.width = width;
    this.sorted = Array.from(table.seen.keys()).sort((a, b) => table.seen[a] - table.seen[b] || a - b);
  }

  /** Selects landmarks observed over at least this many frames; `order` are their rows in the table. */
  livingAtLeast(least) {
    const order = this.sorted.filter((row) => this.columns.life[row] >= least);
    const columns = Object.entries(this.columns).map(([name, values]) => [name, reorder(values, 1, order)]);
    return { order, positions: reorder(this.positions, this.width, order), ...Object.fromEntries(columns) };
  }
}

function fill(object, positions) {
  object.geometry.dispose();
  object.geometry = new BufferGeometry();
  object.geometry.setAttribute("position", new BufferAttribute(positions, 3));
}

/** Draws the landmarks of a run with materials of the caller. */
export class DrawnLandmarks {
  constructor(world, pointMaterial, segmentMaterial) {
    this.points = new Points(new BufferGeometry(), pointMaterial);
    this.segments = new LineSegments(new BufferGeometry(), segmentMaterial);
    this.least = 0;
    for (const object of [this.points, this.segments]) {
      object.frustumCulled = false;
      world.add(object);
    }
  }

  setMap(map) {
    this.rows = { points: new LandmarkRows(map.points, "p", 3), segments: new LandmarkRows(map.segments, "pq", 6) };
    this.setLeast(this.least);
  }

  setLeast(least) {
    this.least = least;
    if (!this.rows) return;
    this.pointData = this.rows.points.livingAtLeast(least);
    this.segmentData = this.rows.segments.livingAtLeast(least);
    fill(this.points, this.pointData.positions);
    fill(this.segments, this.segmentData.positions);
  }

  show(layers, shown = true) {
    this.points.visible = shown && layers.get("points");
    this.segments.visible = shown && layers.get("segments");
  }

  setFrame(frame) {
    if (!this.pointData) return;
    this.points.geometry.setDrawRange(0, countUpTo(this.pointData.seen, frame));
    this.segments.geometry.setDrawRange(0, 2 * countUpTo(this.segmentData.seen, frame));
  }
}

export class Landmarks extends DrawnLandmarks {
  constructor(world) {
    super(world, new ShaderMaterial({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      uniforms: { size: { value: 1 }, pixels: { value: Math.min(2, window.devicePixelRatio || 1) } },
    }), new LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.85 }));
  }

  setRun(run, size) {
    if (!run.map || run.map === this.map) return;
    this.map = run.map;
    this.ranges = {};
    this.points.material.uniforms.size.value = size * 1.6;
    this.setMap(run.map);
  }

  /** `mode`: "height" (along the map's vertical, from its origin), "seen" (first frame), "life" (frames from then to
   * the last observing keyframe), "observations" (observing keyframes). The range is that of all points, also if
   * few are shown. */
  colour(run, mode) {
    if (!this.pointData) return;
    this.up = run.map.vertical.up;
    this.range = mode === "seen" ? [run.frames.id[0], run.frames.id[run.rows - 1]] : (this.ranges[mode] ??= this.rangeOf(mode));
    this.points.geometry.setAttribute("tint", this.tints(this.pointData, 3, 1, mode));
    this.segments.geometry.setAttribute("color", this.tints(this.segmentData, 6, 2, mode));
  }

  /** Range of all points of the map, which are sorted for it. */
  rangeOf(mode) {
    const { positions, columns } = this.rows.points;
    return {
      height: () => quantiles(Float32Array.from(columns.seen, (_, i) => this.height(positions, 3 * i)), 0.03, 0.97),
      life: () => [0, Math.max(8, quantiles(columns.life, 0, 0.95)[1])],
      observations: () => [2, Math.max(8, quantiles(columns.observations, 0, 0.95)[1])],
    }[mode]();
  }

  height(positions, at) {
    return this.up[0] * positions[at] + this.up[1] * positions[at + 1] + this.up[2] * positions[at + 2];
  }

  tints({ positions, ...columns }, width, vertices, mode) {
    const [low, high] = this.range;
    const table = Array.from({ length: kTints }, (_, i) => ramp(scales[mode], i / (kTints - 1)).map((c) => 255 * c));
    const n = columns.seen.length;
    const tints = new Uint8Array(n * vertices * 3);
    for (let i = 0; i < n; ++i) {
      for (let v = 0; v < vertices; ++v) {
        const value = mode === "height" ? this.height(positions, i * width + 3 * v) : columns[mode][i];
        const share = Math.min(1, Math.max(0, (value - low) / (high - low || 1)));
        tints.set(table[Math.round(share * (kTints - 1))], (i * vertices + v) * 3);
      }
    }
    return new BufferAttribute(tints, 3, true);
  }

  setTime(run, row, frame) {
    this.setFrame(frame);
  }
}
