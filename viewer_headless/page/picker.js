// SPDX-License-Identifier: BSD-3-Clause
// Finds the object under the pointer: a keyframe, a point or a segment of the drawn maps.
import { Matrix4 } from "three";
import { countUpTo } from "./data.js";

const kReach_px = 9;
// Keyframes are few and small, landmarks many: a keyframe is preferred if both are near.
const kKeyframeReach_px = 12;

/** Projects positions of the map of an object's parent to pixels of the canvas: [x, y, depth], null behind the eye. */
function projector(view, parent) {
  const { camera, canvas } = view;
  camera.updateMatrixWorld();
  parent.updateWorldMatrix(true, false);
  const m = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).multiply(parent.matrixWorld).elements;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  return (p, at, out = [0, 0, 0]) => {
    const [x, y, z] = [p[at], p[at + 1], p[at + 2]];
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (!(w > 0)) return null;
    out[0] = 0.5 * width * (1 + (m[0] * x + m[4] * y + m[8] * z + m[12]) / w);
    out[1] = 0.5 * height * (1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w);
    out[2] = w;
    return out;
  };
}

function distanceToSegment([x, y], [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay];
  const share = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(x - ax - share * dx, y - ay - share * dy);
}

export class Picker {
  constructor(view) {
    this.view = view;
  }

  /** Projects a position of the page's own map to the canvas, in pixels; null behind the eye. */
  pixelOf(p) {
    return projector(this.view, this.view.world)(p, 0);
  }

  /** {type: "keyframes" | "points" | "segments", row, of} of the tables of a map, or null; `of` is 0 for the page's own run. */
  pick(x, y) {
    const { run, parts, row } = this.view;
    if (!run?.map) return null;
    const frame = row >= run.rows - 1 ? Infinity : run.frames.id[row];
    this.best = null;
    this.pickKeyframe(run, frame, x, y);
    if (this.best) return this.best;
    const drawn = [parts.landmarks, ...parts.others.runs.map((other) => other.landmarks)];
    drawn.forEach((landmarks, of) => landmarks.pointData && this.pickLandmark(landmarks, of, frame, x, y));
    return this.best;
  }

  /** Prefers the object in front if several are equally near the pointer. */
  offer(picked, distance, reach, depth) {
    const cost = distance + 1e-3 * depth / (this.view.size || 1);
    if (distance < reach && (!this.best || cost < this.best.cost)) this.best = { ...picked, cost };
  }

  pickKeyframe(run, frame, x, y) {
    const { layers, own } = this.view;
    if (!layers.get("keyframes") || !own.visible) return;
    const project = projector(this.view, own);
    const { p, frame: frames } = run.map.keyframes;
    for (let k = 0; k < (frames?.length ?? 0); ++k) {
      const at = frames[k] <= frame && project(p, 3 * k);
      if (at) this.offer({ type: "keyframes", row: k, of: 0 }, Math.hypot(at[0] - x, at[1] - y), kKeyframeReach_px, at[2]);
    }
  }

  pickLandmark({ points, segments, pointData, segmentData }, of, frame, x, y) {
    const shown = points.parent.visible;
    const project = projector(this.view, points.parent);
    const [a, b] = [[0, 0, 0], [0, 0, 0]];
    const nPoints = shown && points.visible ? countUpTo(pointData.seen, frame) : 0;
    for (let i = 0; i < nPoints; ++i) {
      if (!project(pointData.positions, 3 * i, a)) continue;
      const distance = Math.hypot(a[0] - x, a[1] - y);
      if (distance < kReach_px) this.offer({ type: "points", row: pointData.order[i], of }, distance, kReach_px, a[2]);
    }
    const nSegments = shown && segments.visible ? countUpTo(segmentData.seen, frame) : 0;
    for (let i = 0; i < nSegments; ++i) {
      if (!project(segmentData.positions, 6 * i, a) || !project(segmentData.positions, 6 * i + 3, b)) continue;
      this.offer({ type: "segments", row: segmentData.order[i], of }, distanceToSegment([x, y], a, b) + 1, kReach_px, Math.min(a[2], b[2]));
    }
  }
}
