// SPDX-License-Identifier: BSD-3-Clause
// The map before and after `plslam refine`, as its summary.json states it.
import { byId, element } from "./element.js";
import { count, fixed } from "./format.js";

/** Returns the summary of a refinement; null if the map was not refined. */
export function embeddedRefinement() {
  const summary = JSON.parse(document.getElementById("run-refinement").textContent);
  return summary?.before && summary?.after ? summary : null;
}

const kRows = [
  ["points", "Points", count],
  ["lines", "Segments", count],
  ["point_observations", "Fitting observations of points", count],
  ["line_observations", "Fitting observations of segments", count],
  ["rms_normalised", "Residual, in sigmas (rms)", (x) => fixed(x, 3)],
  ["rms_points_px", "Residual of points (rms)", (x) => `${fixed(x, 3)} px`],
  ["rms_lines_px", "Residual of segments (rms)", (x) => `${fixed(x, 3)} px`],
  ["loops", "Loops", count],
  ["rms_loops_m", "Position at loops (rms)", (x) => `${fixed(x, 4)} m`],
  ["length_m", "Length along keyframes", (x) => `${fixed(x, 3)} m`],
  ["ate_m", "Error (ATE)", (x) => `${fixed(x, 4)} m`],
];

/** Returns the rows of the table: name, before and after; those of the camera have a value and its sigma. */
export function refinementRows({ before, after, camera }) {
  const maps = kRows.filter(([key]) => before[key] != null && (before.loops > 0 || !key.endsWith("loops_m")))
    .map(([key, name, text]) => [name, text(before[key]), text(after[key])]);
  const parameter = ({ name, unit, state, value, sigma }) => [`Camera: ${name}`, "",
    state === "estimated" ? `${fixed(value, 4)} ${unit}, sigma ${fixed(sigma, 4)}` : state];
  return [...maps, ...camera.map(parameter)];
}

/** Shows the table, if there is one. */
export function showRefinement(summary) {
  byId("refinement").hidden = summary === null;
  if (summary === null) return;
  byId("refinement-lead").textContent = "The map of the run before and after its adjustment as a whole (plslam refine). " +
    "Everything else on this page is as the run left it.";
  const row = (cells, tag) => element("tr", {}, ...cells.map((cell) => element(tag, {}, cell)));
  byId("refinement-table").replaceChildren(element("thead", {}, row(["", "before", "after"], "th")),
    element("tbody", {}, ...refinementRows(summary).map((cells) => row(cells, "td"))));
}
