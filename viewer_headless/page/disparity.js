// SPDX-License-Identifier: BSD-3-Clause
// Disparities of a small rectified pair by block matching, for display: the smallest sum of absolute differences over
// blocks, refined by a parabola. A pixel has none if no minimum is distinct, or if matching the right image with the
// left one gives another one.

const kHalf_px = 3;
const kBlock = (2 * kHalf_px + 1) ** 2;
// Largest mean difference of grey values over a block.
const kMostUnlike = 16;
// The cost of the best disparity away from the minimum must be larger by this factor; if all costs are 0, there is
// none.
const kDistinct = 1.12;

/** Writes the sums of `values` (width x height) over blocks, with borders repeated, into `out`. */
function sumOverBlocks(values, width, height, rows, out) {
  for (let y = 0; y < height; ++y) {
    const at = y * width;
    let sum = 0;
    for (let k = -kHalf_px; k <= kHalf_px; ++k) sum += values[at + Math.min(width - 1, Math.max(0, k))];
    for (let x = 0; x < width; ++x) {
      rows[at + x] = sum;
      sum += values[at + Math.min(width - 1, x + kHalf_px + 1)] - values[at + Math.max(0, x - kHalf_px)];
    }
  }
  for (let x = 0; x < width; ++x) {
    let sum = 0;
    for (let k = -kHalf_px; k <= kHalf_px; ++k) sum += rows[Math.min(height - 1, Math.max(0, k)) * width + x];
    for (let y = 0; y < height; ++y) {
      out[y * width + x] = sum;
      sum += rows[Math.min(height - 1, y + kHalf_px + 1) * width + x] - rows[Math.max(0, y - kHalf_px) * width + x];
    }
  }
}

/** `left` and `right` are grey values, width x height. Returns disparities in their pixels, below `most`; NaN: none. */
export function matchBlocks(left, right, width, height, most) {
  const n = width * height;
  const costs = Array.from({ length: most }, () => new Uint16Array(n));
  const [differences, rows] = [new Uint8Array(n), new Uint16Array(n)];
  costs.forEach((cost, d) => {
    for (let i = 0; i < n; ++i) differences[i] = i % width < d ? 255 : Math.abs(left[i] - right[i - d]);
    sumOverBlocks(differences, width, height, rows, cost);
  });
  const [best, bestRight] = [new Uint16Array(n), new Uint16Array(n)];
  for (let d = 1; d < most; ++d) {
    for (let i = 0; i < n; ++i) {
      if (costs[d][i] < costs[best[i]][i]) best[i] = d;
      if (i % width + d < width && costs[d][i + d] < costs[bestRight[i]][i + bestRight[i]]) bestRight[i] = d;
    }
  }
  return Float32Array.from(best, (d, i) => {
    const cost = costs[d][i];
    if (d < 1 || d >= most - 1 || i % width < d || cost > kMostUnlike * kBlock || Math.abs(bestRight[i - d] - d) > 1) return NaN;
    for (let other = 0; other < most; ++other) {
      if (Math.abs(other - d) > 1 && costs[other][i] <= kDistinct * cost) return NaN;
    }
    const [before, after] = [costs[d - 1][i], costs[d + 1][i]];
    return d + (0.5 * (before - after)) / Math.max(1, before - 2 * cost + after);
  });
}
