// SPDX-License-Identifier: BSD-3-Clause
// Keyframes as frusta, and their edges: covisibility, essential graph (with the spanning tree), loops.
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Quaternion, Vector3 } from "three";
import { themeColour } from "./colours.js";
import { countUpTo } from "./data.js";
import { median } from "./format.js";

const kEssential = 100;

/** Corners of an image at depth 1, and the edges of the pyramid as pairs of corners (0 is the centre). */
export function frustumOf(camera) {
  const c = camera ?? { width_px: 4, height_px: 3, f_px: 3, cx_px: 2, cy_px: 1.5 };
  const x = [-c.cx_px / c.f_px, (c.width_px - c.cx_px) / c.f_px];
  const y = [-c.cy_px / c.f_px, (c.height_px - c.cy_px) / c.f_px];
  return [[0, 0, 0], [x[0], y[0], 1], [x[1], y[0], 1], [x[1], y[1], 1], [x[0], y[1], 1]].map((p) => new Vector3(...p));
}
export const kFrustumEdges = [0, 1, 0, 2, 0, 3, 0, 4, 1, 2, 2, 3, 3, 4, 4, 1];

/** Vertices of a frustum's edges in the map. */
export function putFrustum(corners, depth, p, q, out, at) {
  const rotation = new Quaternion(...q);
  const placed = corners.map((c) => c.clone().multiplyScalar(depth).applyQuaternion(rotation));
  for (const corner of kFrustumEdges) {
    out[at++] = placed[corner].x + p[0];
    out[at++] = placed[corner].y + p[1];
    out[at++] = placed[corner].z + p[2];
  }
  return at;
}

export class Keyframes {
  constructor(world) {
    this.objects = {};
    for (const [name, opacity] of Object.entries({ keyframes: 0.75, covisibility: 0.16, essential: 0.28, loopEdges: 1 })) {
      const object = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ transparent: true, opacity, depthWrite: false }));
      object.frustumCulled = false;
      this.objects[name] = object;
      world.add(object);
    }
    this.ends = {};
    this.covisible = [];
    this.strength = 0;
  }

  retheme() {
    for (const [name, colour] of Object.entries({ keyframes: "keyframe", covisibility: "covisible", essential: "essential", loopEdges: "loop" })) {
      this.objects[name].material.color.set(themeColour(colour));
    }
  }

  setRun(run, size) {
    if (!run.map || run.map === this.map) return;
    this.map = run.map;
    const { p, frame, q, parent } = run.map.keyframes;
    this.frustumDepth = Math.min(size / 25, Math.max(size / 250, 0.45 * median(stepsOf(p))) || size / 60);
    this.makeFrusta(run.facts.camera, p, q, frame);
    const edges = run.map.edges;
    const all = [...(edges.shared ?? [])].map((shared, i) => [edges.ab[2 * i], edges.ab[2 * i + 1], shared]);
    const tree = [...(parent ?? [])].map((a, b) => [a, b]).filter(([a]) => a >= 0);
    const loops = run.map.loop_edges.ab ?? [];
    this.covisible = all;
    this.setStrength(this.strength);
    this.makeEdges("essential", [...all.filter((e) => e[2] >= kEssential), ...tree]);
    this.makeEdges("loopEdges", Array.from({ length: loops.length / 2 }, (_, i) => [loops[2 * i], loops[2 * i + 1]]));
  }

  /** Shows covisibility between keyframes that share at least this many landmarks; returns the number of edges. */
  setStrength(least) {
    this.strength = least;
    if (!this.map) return 0;
    const strong = this.covisible.filter((edge) => edge[2] >= least);
    this.makeEdges("covisibility", strong);
    return strong.length;
  }

  makeFrusta(camera, p, q, frames) {
    const corners = frustumOf(camera);
    const order = Array.from(frames.keys()).sort((a, b) => frames[a] - frames[b]);
    const vertices = new Float32Array(order.length * kFrustumEdges.length * 3);
    let at = 0;
    for (const k of order) at = putFrustum(corners, this.frustumDepth, p.subarray(3 * k, 3 * k + 3), q.subarray(4 * k, 4 * k + 4), vertices, at);
    this.fill("keyframes", vertices);
    this.ends.keyframes = { frames: order.map((k) => frames[k]), vertices: kFrustumEdges.length };
  }

  /** An edge exists from the later of its keyframes on. */
  makeEdges(name, edges) {
    const { p, frame } = this.map.keyframes;
    const since = ([a, b]) => Math.max(frame[a], frame[b]);
    edges.sort((a, b) => since(a) - since(b));
    const vertices = new Float32Array(edges.length * 6);
    edges.forEach(([a, b], i) => {
      vertices.set(p.subarray(3 * a, 3 * a + 3), 6 * i);
      vertices.set(p.subarray(3 * b, 3 * b + 3), 6 * i + 3);
    });
    this.fill(name, vertices);
    this.ends[name] = { frames: edges.map(since), vertices: 2 };
  }

  fill(name, vertices) {
    this.objects[name].geometry.dispose();
    this.objects[name].geometry = new BufferGeometry();
    this.objects[name].geometry.setAttribute("position", new BufferAttribute(vertices, 3));
  }

  show(layers) {
    for (const [name, object] of Object.entries(this.objects)) object.visible = layers.get(name);
  }

  setTime(run, row, frame) {
    for (const [name, { frames, vertices }] of Object.entries(this.ends)) {
      this.objects[name].geometry.setDrawRange(0, vertices * countUpTo(frames, frame));
    }
  }
}

function stepsOf(p) {
  const steps = [];
  for (let i = 3; i < p.length; i += 3) steps.push(Math.hypot(p[i] - p[i - 3], p[i + 1] - p[i - 2], p[i + 2] - p[i - 1]));
  return steps;
}
