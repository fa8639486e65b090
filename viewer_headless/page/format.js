// SPDX-License-Identifier: BSD-3-Clause
// Formats numbers for users.

export function fixed(value, digits) {
  return Number.isFinite(value) ? value.toFixed(digits) : "–";
}

export function count(value) {
  return Number.isFinite(value) ? Math.round(value).toLocaleString("en").replaceAll(",", "\u202f") : "–";
}

/** Returns "1 keyframe", "2 keyframes". */
export function counted(value, name) {
  return `${count(value)} ${name}${value === 1 ? "" : "s"}`;
}

/** The number of keyframes that observe a landmark; it is stored in a byte. */
export function observedBy(keyframes) {
  return keyframes === 255 ? "255 keyframes or more" : counted(keyframes, "keyframe");
}

/** Formats a length with three significant digits and a suitable unit. */
export function metres(value) {
  if (!Number.isFinite(value)) return "–";
  if (Math.abs(value) >= 1000) return `${fixed(value / 1000, 2)} km`;
  if (Math.abs(value) >= 10) return `${fixed(value, 1)} m`;
  if (Math.abs(value) >= 1) return `${fixed(value, 2)} m`;
  if (Math.abs(value) >= 0.1) return `${fixed(value * 100, 1)} cm`;
  if (Math.abs(value) >= 0.01) return `${fixed(value * 100, 2)} cm`;
  return Math.abs(value) >= 5e-5 ? `${fixed(value * 1000, 1)} mm` : "< 0.1 mm";
}

export function seconds(value) {
  if (!Number.isFinite(value)) return "–";
  const minutes = Math.floor(value / 60);
  return minutes ? `${minutes}:${String(Math.floor(value % 60)).padStart(2, "0")} min` : `${fixed(value, 1)} s`;
}

export function median(values) {
  const sorted = [...values].filter(Number.isFinite).sort((a, b) => a - b);
  return sorted.length ? sorted[sorted.length >> 1] : NaN;
}

/** Returns the quantiles `low` and `high`, so that outliers do not use up the colours. */
export function quantiles(values, low, high) {
  const finite = Float32Array.from(values).filter(Number.isFinite).sort();
  if (!finite.length) return [0, 1];
  const at = (share) => finite[Math.floor(share * (finite.length - 1))];
  return [at(low), at(high)];
}

export const states = ["initialising", "tracking", "weak", "lost", "recovered"];
