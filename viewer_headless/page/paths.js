// SPDX-License-Identifier: BSD-3-Clause
// Paths of the camera: the final one, the true one, the one published with each frame, the one of odometry only.
import { FatLine } from "./fat_line.js";

function rowOf(values, row) {
  if (!values || 3 * row + 2 >= values.length) return null;
  const p = [values[3 * row], values[3 * row + 1], values[3 * row + 2]];
  return p.every(Number.isFinite) ? p : null;
}

export class Paths {
  constructor(world) {
    this.lines = {
      truth: new FatLine(world, "truth", 2.5, { opacity: 0.9, order: 1 }),
      odom: new FatLine(world, "odom", 1.8, { order: 2 }),
      live: new FatLine(world, "live", 1.8, { order: 3 }),
      path: new FatLine(world, "path", 3, { order: 4 }),
    };
  }

  retheme() {
    for (const line of Object.values(this.lines)) line.retheme();
  }

  setResolution(width, height) {
    for (const line of Object.values(this.lines)) line.setResolution(width, height);
  }

  setRun(run, size) {
    const step = size / 3000;
    // Initialising without landmarks, or lost: the pose of the camera is unknown.
    const lost = (row) => run.frames.state[row] === 3 || (run.frames.state[row] === 0 && !run.frames.keyframe[row]);
    this.lines.path.setPath(run.rows, (row) => {
      const p = run.position(row, [0, 0, 0]);
      return lost(row) || !p.every(Number.isFinite) ? null : p;
    }, step);
    this.lines.truth.setPath(run.rows, (row) => rowOf(run.path?.truth, row), step);
    this.lines.live.setPath(run.rows, (row) => (lost(row) ? null : rowOf(run.frames.live, row)), step);
    this.lines.odom.setPath(run.rows, (row) => {
      const sameSession = row === 0 || run.frames.session[row] === run.frames.session[row - 1];
      return sameSession ? rowOf(run.frames.odom, row) : null;
    }, step);
  }

  show(layers) {
    for (const [name, line] of Object.entries(this.lines)) line.visible = layers.get(name);
  }

  setTime(run, row) {
    for (const line of Object.values(this.lines)) line.showUpTo(row);
  }
}
