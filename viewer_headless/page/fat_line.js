// SPDX-License-Identifier: BSD-3-Clause
// A line of several pixels width through positions, interrupted at missing ones; a part of it can be shown.
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { themeColour } from "./colours.js";
import { countUpTo } from "./data.js";

export class FatLine {
  constructor(world, colour, width, options = {}) {
    this.colour = colour;
    this.material = new LineMaterial({ linewidth: width, worldUnits: false, transparent: true, depthWrite: false, opacity: options.opacity ?? 1 });
    this.object = new LineSegments2(new LineSegmentsGeometry(), this.material);
    this.object.frustumCulled = false;
    this.object.renderOrder = options.order ?? 0;
    this.rows = [];
    world.add(this.object);
  }

  retheme() {
    this.material.color.set(themeColour(this.colour));
  }

  setResolution(width, height) {
    this.material.resolution.set(width, height);
  }

  /** `at(row)` returns [x, y, z] or null; steps below `minStep` are merged. */
  setPath(rows, at, minStep = 0) {
    const pairs = [];
    this.rows = [];
    let previous = null;
    for (let row = 0; row < rows; ++row) {
      const p = at(row);
      if (previous && p) {
        const short = Math.hypot(p[0] - previous[0], p[1] - previous[1], p[2] - previous[2]) < minStep;
        if (short && row < rows - 1) continue;
        pairs.push(...previous, ...p);
        this.rows.push(row);
      }
      previous = p;
    }
    this.setPairs(pairs);
  }

  setPairs(pairs) {
    this.object.geometry.dispose();
    this.object.geometry = new LineSegmentsGeometry();
    this.empty = pairs.length === 0;
    this.object.geometry.setPositions(this.empty ? [0, 0, 0, 0, 0, 0] : pairs);
    this.n = pairs.length / 6;
  }

  showUpTo(row) {
    this.object.geometry.instanceCount = countUpTo(this.rows, row);
  }

  set visible(visible) {
    this.object.visible = visible && !this.empty;
  }
}
