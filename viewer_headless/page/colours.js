// SPDX-License-Identifier: BSD-3-Clause
// Colours of data, apart from those of the page (style.css).

function parse(hex) {
  return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
}

// Low is cold and high is warm; young is violet and old is yellow. All are visible on white and on black.
const kHeight = ["#2f55a8", "#2f86b5", "#35a08c", "#86a944", "#d6983a", "#c9503c"].map(parse);
const kAge = ["#6a3fb5", "#4a6fc4", "#2f93a0", "#3fae78", "#8fc24d", "#e0c93a"].map(parse);
// Far is cold and near is warm, on pictures of any brightness.
const kNear = ["#3f6fe0", "#2fb6c8", "#58c24a", "#e8c832", "#e2483d"].map(parse);

export const scales = {
  height: kHeight,
  seen: kAge,
  life: kAge,
  observations: kAge,
  near: kNear,
};

/** Returns the colour of a share from 0 to 1, as [r, g, b]. */
export function ramp(stops, share) {
  const at = Math.min(1, Math.max(0, share)) * (stops.length - 1);
  const i = Math.min(stops.length - 2, Math.floor(at));
  const f = at - i;
  return stops[i].map((value, k) => value * (1 - f) + stops[i + 1][k] * f);
}

export function css([r, g, b]) {
  return `rgb(${Math.round(255 * r)} ${Math.round(255 * g)} ${Math.round(255 * b)})`;
}

export function cssGradient(stops) {
  return `linear-gradient(to right, ${stops.map(css).join(", ")})`;
}

/** Returns a named colour of the style of the page. */
export function themeColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

// Colours of plot series, distinguishable by hue and by lightness, on white and on black.
export const series = ["#4c8dde", "#e0853d", "#43a888", "#c25b8e", "#9a7bd1", "#b8a032", "#7f8c99", "#d2604f"];
