// SPDX-License-Identifier: BSD-3-Clause
// A correction of the map by a loop: keyframes at their positions before, in between, and after.
import { FatLine } from "./fat_line.js";

export class Correction {
  constructor(world) {
    this.line = new FatLine(world, "before", 3, { order: 5 });
    this.moves = new FatLine(world, "before", 1, { opacity: 0.35, order: 5 });
    this.chosen = null;
    this.blend = 1;
  }

  retheme() {
    this.line.retheme();
    this.moves.retheme();
  }

  setResolution(width, height) {
    this.line.setResolution(width, height);
    this.moves.setResolution(width, height);
  }

  /** `correction` of the run or null; `blend` 0 is before, 1 after (and then nothing is drawn). */
  choose(correction, blend) {
    this.chosen = correction;
    this.blend = blend;
    this.update();
  }

  update() {
    const visible = !!this.chosen && this.blend < 1;
    if (visible) {
      const { before, after } = this.chosen.table;
      const at = (row) => [0, 1, 2].map((k) => before[3 * row + k] * (1 - this.blend) + after[3 * row + k] * this.blend);
      const rows = before.length / 3;
      this.line.setPath(rows, at);
      const pairs = [];
      for (let row = 0; row < rows; ++row) pairs.push(...at(row), ...after.subarray(3 * row, 3 * row + 3));
      this.moves.setPairs(pairs);
    }
    this.line.visible = visible;
    this.moves.visible = visible;
  }
}
