// SPDX-License-Identifier: BSD-3-Clause
// What stands under the pointer: a keyframe, a point or a segment of the map that is drawn.
import { Matrix4 } from "three";
import { countUpTo } from "./data.js";

const kReach_px = 9;
// Keyframes are few and small, landmarks many: what is near both is meant to be the keyframe.
const kKeyframeReach_px = 12;

/** Takes positions of the map to pixels of the canvas: [x, y, depth], null behind the eye. */
function projector(view) {
  const { camera, world, canvas } = view;
  camera.updateMatrixWorld();
  world.updateMatrixWorld();
  const m = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).multiply(world.matrixWorld).elements;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  return (p, at) => {
    const [x, y, z] = [p[at], p[at + 1], p[at + 2]];
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (!(w > 0)) return null;
    const u = (m[0] * x + m[4] * y + m[8] * z + m[12]) / w;
    const v = (m[1] * x + m[5] * y + m[9] * z + m[13]) / w;
    return [0.5 * width * (1 + u), 0.5 * height * (1 - v), w];
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

  /** Where a position of the map is on the canvas, in pixels; null behind the eye. */
  pixelOf(p) {
    return projector(this.view)(p, 0);
  }

  /** {type: "keyframes" | "points" | "segments", row} of the tables of the map, or null. */
  pick(x, y) {
    const { run, layers, parts, row } = this.view;
    if (!run?.map) return null;
    const frame = row >= run.rows - 1 ? Infinity : run.frames.id[row];
    const project = projector(this.view);
    let best = null;
    const offer = (type, row, distance, reach, depth) => {
      // Of what is equally near the pointer, the one in front.
      const cost = distance + 1e-3 * depth / (this.view.size || 1);
      if (distance < reach && (!best || cost < best.cost)) best = { type, row, cost };
    };
    if (layers.get("keyframes")) {
      const keyframes = run.map.keyframes;
      for (let k = 0; k < keyframes.frame.length; ++k) {
        const at = keyframes.frame[k] <= frame && project(keyframes.p, 3 * k);
        if (at) offer("keyframes", k, Math.hypot(at[0] - x, at[1] - y), kKeyframeReach_px, at[2]);
      }
    }
    if (best) return best;
    const { pointData, segmentData } = parts.landmarks;
    for (let i = 0; layers.get("points") && i < countUpTo(pointData.seen, frame); ++i) {
      const at = project(pointData.positions, 3 * i);
      if (at) offer("points", pointData.order[i], Math.hypot(at[0] - x, at[1] - y), kReach_px, at[2]);
    }
    for (let i = 0; layers.get("segments") && i < countUpTo(segmentData.seen, frame); ++i) {
      const p = project(segmentData.positions, 6 * i);
      const q = project(segmentData.positions, 6 * i + 3);
      if (p && q) offer("segments", segmentData.order[i], distanceToSegment([x, y], p, q) + 1, kReach_px, Math.min(p[2], q[2]));
    }
    return best;
  }
}
