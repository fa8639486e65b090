// SPDX-License-Identifier: BSD-3-Clause
// Paths and landmarks of other runs of the same dataset, each in one colour, in the map of the page's own run.
import { Group, LineBasicMaterial, Matrix4, PointsMaterial } from "three";
import { themeColour } from "./colours.js";
import { countUpTo, Run } from "./data.js";
import { FatLine } from "./fat_line.js";
import { DrawnLandmarks } from "./landmarks.js";

const kPoint_px = 2.2;

class Other {
  /** `transform`: 16 numbers, row by row, from the map of the other run to the page's own; `data` as written by the
   * viewer. */
  constructor(world, name, { label, transform, data }) {
    this.name = name;
    this.run = new Run();
    this.run.take(data);
    this.run.label = label;
    this.run.transform = new Matrix4().set(...transform);
    this.group = new Group();
    this.group.matrixAutoUpdate = false;
    this.group.matrix.copy(this.run.transform);
    world.add(this.group);
    this.line = new FatLine(this.group, name, 3, { order: 3 });
    this.landmarks = new DrawnLandmarks(this.group,
      new PointsMaterial({ size: kPoint_px * Math.min(2, window.devicePixelRatio || 1), sizeAttenuation: false }),
      new LineBasicMaterial({ transparent: true, opacity: 0.8 }));
    this.landmarks.setMap(this.run.map);
  }

  retheme() {
    this.line.retheme();
    for (const object of [this.landmarks.points, this.landmarks.segments]) object.material.color.set(themeColour(this.name));
  }

  setSize(size) {
    const { state, keyframe } = this.run.frames;
    const at = (row) => {
      const p = this.run.position(row, [0, 0, 0]);
      const lost = state[row] === 3 || (state[row] === 0 && !keyframe[row]);
      return lost || !p.every(Number.isFinite) ? null : p;
    };
    this.line.setPath(this.run.rows, at, size / 3000);
  }

  show(layers) {
    const shown = layers.get(this.name);
    this.line.visible = shown && layers.get("path");
    this.landmarks.show(layers, shown);
  }

  setTime(frame) {
    this.line.showUpTo(countUpTo(this.run.frames.id, frame) - 1);
    this.landmarks.setFrame(frame);
  }
}

export class Others {
  constructor(world, others) {
    this.runs = others.map((other, i) => new Other(world, `other${i}`, other));
  }

  retheme() {
    for (const run of this.runs) run.retheme();
  }

  setResolution(width, height) {
    for (const run of this.runs) run.line.setResolution(width, height);
  }

  setRun(run, size) {
    for (const other of this.runs) other.setSize(size);
  }

  setLeast(least) {
    for (const run of this.runs) run.landmarks.setLeast(least);
  }

  show(layers) {
    for (const run of this.runs) run.show(layers);
  }

  setTime(run, row, frame) {
    for (const other of this.runs) other.setTime(frame);
  }
}
