// SPDX-License-Identifier: BSD-3-Clause
// Paths and landmarks of other runs of the same dataset, each in one colour, in the map of the page's own run.
import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments, Matrix4, Points, PointsMaterial } from "three";
import { themeColour } from "./colours.js";
import { countUpTo, decodeTable } from "./data.js";
import { FatLine } from "./fat_line.js";
import { sortBySeen } from "./landmarks.js";

const kPoint_px = 2.2;

function geometryOf(positions) {
  return new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3));
}

class Other {
  /** `transform`: 16 numbers, row by row, that take the map of the other run into the page's. */
  constructor(world, name, { transform, frames, path, points, segments }) {
    this.name = name;
    this.frames = decodeTable(frames);
    this.path = decodeTable(path).p;
    this.group = new Group();
    this.group.matrixAutoUpdate = false;
    this.group.matrix.copy(new Matrix4().set(...transform));
    world.add(this.group);
    this.line = new FatLine(this.group, name, 3, { order: 3 });
    this.pointData = sortBySeen(decodeTable(points), "p", 3);
    this.segmentData = sortBySeen(decodeTable(segments), "pq", 6);
    this.points = new Points(geometryOf(this.pointData.positions),
      new PointsMaterial({ size: kPoint_px * Math.min(2, window.devicePixelRatio || 1), sizeAttenuation: false }));
    this.segments = new LineSegments(geometryOf(this.segmentData.positions), new LineBasicMaterial({ transparent: true, opacity: 0.8 }));
    for (const object of [this.points, this.segments]) {
      object.frustumCulled = false;
      this.group.add(object);
    }
  }

  retheme() {
    this.line.retheme();
    for (const object of [this.points, this.segments]) object.material.color.set(themeColour(this.name));
  }

  setSize(size) {
    const { id, state, keyframe } = this.frames;
    const at = (row) => {
      const p = [0, 1, 2].map((k) => this.path[3 * row + k]);
      const lost = state[row] === 3 || (state[row] === 0 && !keyframe[row]);
      return lost || !p.every(Number.isFinite) ? null : p;
    };
    this.line.setPath(Math.min(id.length, this.path.length / 3), at, size / 3000);
  }

  show(layers) {
    const shown = layers.get(this.name);
    this.line.visible = shown;
    this.points.visible = shown && layers.get("points");
    this.segments.visible = shown && layers.get("segments");
  }

  setTime(frame) {
    this.line.showUpTo(countUpTo(this.frames.id, frame) - 1);
    this.points.geometry.setDrawRange(0, countUpTo(this.pointData.seen, frame));
    this.segments.geometry.setDrawRange(0, 2 * countUpTo(this.segmentData.seen, frame));
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

  show(layers) {
    for (const run of this.runs) run.show(layers);
  }

  setTime(run, row, frame) {
    for (const other of this.runs) other.setTime(frame);
  }
}
