// SPDX-License-Identifier: BSD-3-Clause
// The head of the page: a summary of the run in a line of numbers.
import { byId, element } from "./element.js";
import { count, counted, fixed, median, metres, seconds } from "./format.js";

function totalStage(run) {
  const width = run.frameWidths.stages_ms;
  if (!run.stageNames.length) return NaN;
  // A stage named "total" includes the others.
  const total = run.stageNames.indexOf("total");
  const totals = [];
  for (let row = 0; row < run.rows; ++row) {
    let sum = 0;
    for (let i = 0; i < width; ++i) {
      const ms = run.frames.stages_ms[row * width + i];
      if (Number.isFinite(ms) && (total < 0 || i === total)) sum += ms;
    }
    totals.push(sum);
  }
  return median(totals);
}

/** Returns the counts of frames that are not tracked: "90 initialising, 2 lost". */
export function notTracked(f) {
  const parts = [["initialising", f.initialising_frames], ["lost", f.lost_frames], ["skipped", f.skipped_frames],
    ["unreadable", f.bad_frames], ["unanswered", f.unanswered_frames]];
  return parts.filter(([, n]) => n > 0).map(([name, n]) => `${count(n)} ${name}`).join(", ") || "none lost";
}

function figures(run) {
  const f = run.facts;
  const tracked = f.tracked_percent ?? NaN;
  const announced = !f.finished && f.announced_frames > 0 ? ` of ${count(f.announced_frames)}` : "";
  return [
    ["Frames", count(f.all_frames) + announced, seconds(f.duration_s)],
    ["Tracked", `${fixed(tracked, tracked === 100 ? 0 : 1)} %`, notTracked(f)],
    ["Path", metres(f.length_m), counted(f.keyframes, "keyframe")],
    f.ate_m != null && ["Error (ATE)", metres(f.ate_m), `${metres(f.live_ate_m)} as published`],
    f.points > 0 && ["Map", count(f.points), `points, ${counted(f.lines, "segment")}`],
    f.points > 0 && ["Loops", count(f.loops), f.loops ? "closed" : "none found"],
    f.moving?.bodies > 0 && ["Moving objects", count(f.moving.bodies), `up to ${fixed(f.moving.percent, 0)} % of the ` +
      `features, frames ${f.moving.first_frame} to ${f.moving.last_frame}`],
    ["Odometry", `${fixed(totalStage(run), 1)} ms`, "per frame, median"],
  ].filter(Boolean);
}

export function showSummary(run) {
  const f = run.facts;
  // A folder is shown by its last name, a built-in world with all its options.
  const name = f.dataset?.startsWith("/") ? f.dataset.split("/").filter(Boolean).pop() : f.dataset;
  const [short, more] = (name || "unnamed run").split("?");
  byId("dataset").replaceChildren(short, element("small", {}, more?.replaceAll("&", " · ") ?? ""));
  byId("dataset").title = f.dataset ?? "";
  document.title = `${name || "run"} · PL-SLAM`;
  byId("summary").replaceChildren(
    ...figures(run).map(([name, value, more]) =>
      element("div", {}, element("dt", {}, name), element("dd", {}, value, element("small", {}, more)))),
  );
}

/** Shows the runs of a page of several runs, one row each. */
export function showRuns(runs) {
  const titles = [...new Set(runs.flatMap(({ run }) => figures(run).map(([title]) => title)))];
  const row = ({ name, colour, run }) => {
    const cells = new Map(figures(run).map(([title, value, more]) => [title, [value, element("small", {}, more)]]));
    return element("tr", {}, element("th", {}, element("i", { class: "swatch thick", style: `--swatch: var(--${colour})` }), name),
      ...titles.map((title) => element("td", { "data-name": title }, ...(cells.get(title) ?? ["–"]))));
  };
  byId("summary").hidden = true;
  byId("runs").hidden = false;
  byId("run-table").replaceChildren(element("thead", {}, element("tr", {}, ...["run", ...titles].map((title) => element("th", {}, title)))),
    element("tbody", {}, ...runs.map(row)));
  document.documentElement.style.setProperty("--runs", `${byId("runs").offsetHeight + 16}px`);
}

/** Follows the height of the box of warnings. */
let boxSize;

/** Shows a box at the top if there are warnings. */
export function showWarnings(run) {
  const warnings = run.facts.warnings ?? [];
  const box = byId("warnings");
  box.hidden = warnings.length === 0;
  box.replaceChildren(...warnings.map((w) => element("li", {}, w.sentence)));
  // The map below shrinks, so that it and its replay stay in the window.
  boxSize ??= new ResizeObserver(() => {
    const height = box.hidden ? 0 : box.offsetHeight + 16;
    document.documentElement.style.setProperty("--warnings", `${height}px`);
  });
  boxSize.observe(box);
}

export function showKicker(run, state) {
  const parts = ["PL-SLAM run", run.facts.pace, run.facts.version && `version ${run.facts.version}`, state];
  byId("kicker").textContent = parts.filter(Boolean).join(" · ");
}

/** Returns a sentence about the vertical direction. */
function upright(run) {
  const vertical = run.map?.vertical ?? { from: "cameras" };
  const sigma = `(sigma ${vertical.sigma_deg?.toPrecision(2)} degrees)`;
  const source = {
    gravity: () => `Up is against gravity, as the inertial sensor measured it from ${count(vertical.n)} keyframes ${sigma}`,
    lines: () => `Up is the direction that ${count(vertical.n)} upright segments of the map share ${sigma}`,
    cameras: () => "Up is the mean of the cameras (the map has no upright segments that agree)",
  }[vertical.from]();
  return `${source}; heights are measured along it from the first camera.`;
}

/** Returns a sentence about the inertial sensor as [text], empty for runs without one. */
function sensor(run) {
  const imu = run.facts.imu;
  if (!imu) return [];
  const bias = (values, sigma) => `[${values.map((v) => v.toPrecision(2)).join(", ")}] ± ${(3 * sigma).toPrecision(2)}`;
  const delay = imu.delay_ms === null ? "" : `, stamps late by ${imu.delay_ms.toFixed(1)} ± ${(3 * imu.delay_sigma_ms).toFixed(1)} ms`;
  return [`The inertial sensor was used in ${count(imu.used_frames)} of ${count(run.facts.frames)} frames (normalised innovation ` +
    `${imu.innovation.toFixed(2)}, 1 is consistent; biases with three sigmas ${bias(imu.rate_bias_rad_s, imu.rate_bias_sigma_rad_s)} rad/s ` +
    `and ${bias(imu.force_bias_m_s2, imu.force_bias_sigma_m_s2)} m/s²${delay}).`];
}

export function showNotes(run) {
  const lead = "Positions are in the map's frame (x right, y down, z forward at the start). The true path is aligned with the " +
    "estimated one by a rigid motion.";
  byId("notes").textContent = [lead, upright(run), ...sensor(run), ...run.notes].join(" ");
}
