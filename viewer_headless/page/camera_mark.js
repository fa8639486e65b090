// SPDX-License-Identifier: BSD-3-Clause
// The camera of the current frame, and the position of an eye that follows it.
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Quaternion, Vector3 } from "three";
import { themeColour } from "./colours.js";
import { frustumOf, kFrustumEdges, putFrustum } from "./keyframes.js";

export class CameraMark {
  constructor(world) {
    this.vertices = new Float32Array(kFrustumEdges.length * 3);
    this.object = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ depthTest: false }));
    this.object.geometry.setAttribute("position", new BufferAttribute(this.vertices, 3));
    this.object.frustumCulled = false;
    this.object.renderOrder = 10;
    world.add(this.object);
    this.depth = 1;
  }

  retheme() {
    this.object.material.color.set(themeColour("camera"));
  }

  setRun(run, size) {
    this.corners = frustumOf(run.facts.camera);
    this.depth = size / 28;
  }

  pose(run, row) {
    const p = run.position(row, [0, 0, 0]);
    const known = run.path && 4 * row + 3 < run.path.q.length;
    const q = known ? run.path.q.subarray(4 * row, 4 * row + 4) : this.lastQ ?? [0, 0, 0, 1];
    this.lastQ = q;
    return { p, q };
  }

  setTime(run, row) {
    const { p, q } = this.pose(run, row);
    putFrustum(this.corners, this.depth, p, q, this.vertices, 0);
    this.object.geometry.attributes.position.needsUpdate = true;
  }

  /** Returns eye and target in the coordinates of the scene (y up). */
  behind(run, row, back, up, ahead) {
    const { p, q } = this.pose(run, row);
    const rotation = new Quaternion(...q);
    const place = (x, y, z) => {
      const moved = new Vector3(x, y, z).applyQuaternion(rotation).add(new Vector3(...p));
      return this.object.parent.localToWorld(moved);
    };
    return [place(0, -up, -back), place(0, 0, ahead)];
  }
}
