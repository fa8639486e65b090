// SPDX-License-Identifier: BSD-3-Clause
// Two clocks of a run: the time of the recording, and that of the host, used in the statuses of processes.
import { countUpTo } from "./data.js";

/** Interpolates linearly the value of `to` at x of the ascending `from`. */
function interpolate(from, to, x) {
  const after = countUpTo(from, x);
  if (after === 0) return to[0];
  if (after === from.length) return to.at(-1);
  const share = (x - from[after - 1]) / (from[after] - from[after - 1]);
  return to[after - 1] + share * (to[after] - to[after - 1]);
}

export class WallClock {
  /** Made from the statuses of the processes: the newest frame at each of their samples. */
  constructor(run) {
    const samples = run.processes.flatMap(({ table }) => Array.from(table.t_s ?? [], (wall, i) => [wall, table.frame[i]]))
      .filter(([, frame]) => frame >= 0)
      .sort((a, b) => a[0] - b[0]);
    // If there is no new frame between samples, only the first one counts, so that both ascend.
    this.wall = [];
    this.time = [];
    for (const [wall, frame] of samples) {
      const t = run.frames.t_s[run.rowOf(frame)];
      if (this.time.length && !(t > this.time.at(-1) && wall > this.wall.at(-1))) continue;
      this.wall.push(wall);
      this.time.push(t);
    }
  }

  /** Returns null if nothing is known. */
  wallAt(t) {
    return this.time.length ? interpolate(this.time, this.wall, t) : null;
  }

  timeAt(wall) {
    return this.wall.length ? interpolate(this.wall, this.time, wall) : null;
  }
}
