// SPDX-License-Identifier: BSD-3-Clause
// Points and segments of the map, each kind as one geometry. In the order they were first seen, so that a moment of the
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

/** `rows` of `width` numbers in a new order. */
function reorder(values, width, order) {
  const result = new values.constructor(values.length);
  order.forEach((row, i) => result.set(values.subarray(row * width, (row + 1) * width), i * width));
  return result;
}

export function sortBySeen(table, name, width) {
  const order = Array.from(table.seen.keys()).sort((a, b) => table.seen[a] - table.seen[b] || a - b);
  return { order, positions: reorder(table[name], width, order), seen: reorder(table.seen, 1, order), observations: reorder(table.observations ?? table.seen, 1, order) };
}

export class Landmarks {
  constructor(world) {
    this.pointMaterial = new ShaderMaterial({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      uniforms: { size: { value: 1 }, pixels: { value: Math.min(2, window.devicePixelRatio || 1) } },
    });
    this.points = new Points(new BufferGeometry(), this.pointMaterial);
    this.segments = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.85 }));
    for (const object of [this.points, this.segments]) {
      object.frustumCulled = false;
      world.add(object);
    }
  }

  setRun(run, size) {
    if (!run.map || run.map === this.map) return;
    this.map = run.map;
    this.pointMaterial.uniforms.size.value = size * 1.6;
    this.pointData = sortBySeen(run.map.points, "p", 3);
    this.segmentData = sortBySeen(run.map.segments, "pq", 6);
    this.fill(this.points, this.pointData.positions);
    this.fill(this.segments, this.segmentData.positions);
  }

  fill(object, positions) {
    object.geometry.dispose();
    object.geometry = new BufferGeometry();
    object.geometry.setAttribute("position", new BufferAttribute(positions, 3));
  }

  /** `mode`: "height" (along the map's vertical, from its origin), "seen" (when first), "observations" (keyframes that see it). */
  colour(run, mode) {
    if (!this.pointData) return;
    this.up = run.map.vertical.up;
    const heights = this.pointData.seen.length ? Float32Array.from(this.pointData.seen, (_, i) => this.height(this.pointData.positions, 3 * i)) : [];
    this.range = {
      height: quantiles(heights, 0.03, 0.97),
      seen: [run.frames.id[0], run.frames.id[run.rows - 1]],
      observations: [2, Math.max(8, quantiles(this.pointData.observations, 0, 0.95)[1])],
    }[mode];
    this.points.geometry.setAttribute("tint", this.tints(this.pointData, 3, 1, mode));
    this.segments.geometry.setAttribute("color", this.tints(this.segmentData, 6, 2, mode));
  }

  height(positions, at) {
    return this.up[0] * positions[at] + this.up[1] * positions[at + 1] + this.up[2] * positions[at + 2];
  }

  tints({ positions, seen, observations }, width, vertices, mode) {
    const [low, high] = this.range;
    const tints = new Uint8Array(seen.length * vertices * 3);
    for (let i = 0; i < seen.length; ++i) {
      for (let v = 0; v < vertices; ++v) {
        const value = mode === "height" ? this.height(positions, i * width + 3 * v) : mode === "seen" ? seen[i] : observations[i];
        const colour = ramp(scales[mode], (value - low) / (high - low || 1));
        for (let k = 0; k < 3; ++k) tints[(i * vertices + v) * 3 + k] = 255 * colour[k];
      }
    }
    return new BufferAttribute(tints, 3, true);
  }

  show(layers) {
    this.points.visible = layers.get("points");
    this.segments.visible = layers.get("segments");
  }

  setTime(run, row, frame) {
    if (!this.pointData) return;
    this.points.geometry.setDrawRange(0, countUpTo(this.pointData.seen, frame));
    this.segments.geometry.setDrawRange(0, 2 * countUpTo(this.segmentData.seen, frame));
  }
}
