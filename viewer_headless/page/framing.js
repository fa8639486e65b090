// SPDX-License-Identifier: BSD-3-Clause
// The relevant part of a map, and the position of an eye that sees all of it. Plain numbers: [x, y, z, x, y, z, ...].
import { quantiles } from "./format.js";

const kLow = 0.05;
const kHigh = 0.95;
// Landmarks farther from the path than this many times its size are ignored, so that a few far points do not shrink it.
const kReach = 3;
// Share of the picture that is filled.
const kFilled = 0.92;

function boundsOf(points) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], points[i]);
    high[i % 3] = Math.max(high[i % 3], points[i]);
  }
  return [low, high];
}

export function diagonalOf(points) {
  const [low, high] = boundsOf(points);
  return points.length ? Math.hypot(...[0, 1, 2].map((k) => high[k] - low[k])) : 0;
}

/** Returns the whole path and the landmarks within the central 90 % along each axis, if they are near the path. */
export function worthSeeing(path, landmarks) {
  const axes = [0, 1, 2].map((axis) => landmarks.filter((_, i) => i % 3 === axis));
  const limits = axes.map((values) => quantiles(values, kLow, kHigh));
  const [low, high] = path.length ? boundsOf(path) : [limits.map((l) => l[0]), limits.map((l) => l[1])];
  const reach = kReach * Math.max(1, Math.hypot(...[0, 1, 2].map((k) => high[k] - low[k])));
  const kept = [...path];
  for (let i = 0; i + 2 < landmarks.length; i += 3) {
    const p = landmarks.subarray(i, i + 3);
    const inside = [0, 1, 2].every((k) =>
      p[k] >= Math.max(limits[k][0], low[k] - reach) && p[k] <= Math.min(limits[k][1], high[k] + reach));
    if (inside) kept.push(...p);
  }
  return kept.length ? kept : [-1, -1, -1, 1, 1, 1];
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((v) => v / Math.hypot(...a));

/**
 * Returns the nearest eye that sees all points from a direction (from the target to the eye), with `up` upwards in the
 * picture: {target, distance}. `tangents`: tangents of half the angles of view, [horizontal, vertical]. A point at x to
 * the right and z towards the eye is visible from (c, d) if |x - c| <= tangent * (d - z), so the largest x / tangent +
 * z and -x / tangent + z of all points determine the result.
 */
export function fitView(points, direction, up, tangents) {
  const towards = unit(direction);
  const right = unit(cross(up, towards));
  const axes = [right, cross(towards, right)];
  let near = -Infinity;
  let far = Infinity;
  const most = [[-Infinity, -Infinity], [-Infinity, -Infinity]];
  for (let i = 0; i + 2 < points.length; i += 3) {
    const p = [points[i], points[i + 1], points[i + 2]];
    const z = dot(towards, p);
    near = Math.max(near, z);
    far = Math.min(far, z);
    axes.forEach((axis, k) => {
      const x = dot(axis, p) / (kFilled * tangents[k]);
      most[k][0] = Math.max(most[k][0], x + z);
      most[k][1] = Math.max(most[k][1], -x + z);
    });
  }
  const middle = 0.5 * (near + far);
  const centre = most.map(([a, b], k) => 0.5 * kFilled * tangents[k] * (a - b));
  const height = Math.max(...most.map(([a, b]) => 0.5 * (a + b)));
  const target = [0, 1, 2].map((k) => centre[0] * axes[0][k] + centre[1] * axes[1][k] + middle * towards[k]);
  return { target, distance: Math.max(height - middle, 1e-3) };
}
