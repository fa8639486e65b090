// SPDX-License-Identifier: BSD-3-Clause
// Table of the processes: lag, time per frame, length of queues, restarts.
import { byId, element } from "./element.js";
import { count, counted, fixed, median } from "./format.js";

// Number of the newest frames or updates for the median time.
const kNewest = 50;

function newestTotals(values, width, names) {
  const rows = width ? Math.floor(values.length / width) : 0;
  const total = names.indexOf("total");
  return Array.from({ length: Math.min(kNewest, rows) }, (_, i) => {
    const row = Array.from(values.subarray((rows - 1 - i) * width, (rows - i) * width)).filter((_, k) => total < 0 || k === total);
    return row.filter(Number.isFinite).reduce((sum, ms) => sum + ms, 0);
  });
}

/** Returns the CPU time between the first and the last row. A restarted process counts from 0. */
export function cpuTime_s(cpu_s) {
  return cpu_s.reduce((sum, now, i) => sum + (i ? Math.max(0, now - cpu_s[i - 1]) : 0), 0);
}

/** Returns the time per frame (mapping: per update of the map); for other processes their CPU time per frame. */
function work(run, { name, table }) {
  if (name.startsWith("vo") && run.rows) return `${fixed(median(newestTotals(run.frames.stages_ms, run.frameWidths.stages_ms, run.stageNames)), 1)} ms`;
  if (name.startsWith("mapping") && run.mapTimes.stages_ms?.length) {
    return `${fixed(median(newestTotals(run.mapTimes.stages_ms, run.mapStageNames.length, run.mapStageNames)), 1)} ms per update`;
  }
  const first = Math.max(0, table.frame.findIndex((frame) => frame >= 0));
  const frames = table.frame.at(-1) - table.frame[first];
  return frames > 0 ? `${fixed((1000 * cpuTime_s(table.cpu_s.subarray(first))) / frames, 1)} ms of CPU` : "–";
}

/** Returns the lag of a process in frames and in time of the recording. */
function lag(run, frames) {
  if (frames === null || run.facts.finished) return "–";
  const t = run.frames.t_s;
  const period_s = run.rows > 1 ? (t[run.rows - 1] - t[0]) / (run.frames.id[run.rows - 1] - run.frames.id[0]) : NaN;
  return `${counted(frames, "frame")}${frames && period_s > 0 ? ` (${fixed(frames * period_s, 2)} s)` : ""}`;
}

/** Returns [text, style]. After the end of a run every process has ended, independent of its last status. */
function stateOf(run, p) {
  if (p.state === "failed") return ["failed", "bad"];
  if (run.facts.finished) return ["ended", "finished"];
  if (p.pace === "silent" || p.pace === "gone") return [p.state === "stopping" ? p.state : `silent for ${count(p.silent_s)} s`, "bad"];
  return [p.pace === "behind" ? `${p.state}, behind` : p.state, p.pace === "behind" || p.restarts ? "restarted" : p.state];
}

const kColumns = ["process", "state", "lag", "time per frame", "waiting", "restarts"];

export function showProcesses(run) {
  byId("processes").hidden = run.processes.length === 0;
  const rows = run.processes.map((p) => {
    const [state, look] = stateOf(run, p);
    const hasQueue = Object.keys(p.table).some((name) => name.startsWith("queue."));
    const cells = { process: p.name, state, lag: lag(run, p.lag_frames), work: work(run, p), queue: hasQueue ? count(p.queue) : "–", restarts: `${p.restarts}` };
    return element("tr", { "data-process": p.name, class: look },
      ...Object.entries(cells).map(([name, text]) => element(name === "process" ? "th" : "td", { "data-name": name }, text)));
  });
  byId("process-table").replaceChildren(element("thead", {}, element("tr", {}, ...kColumns.map((name) => element("th", {}, name)))),
    element("tbody", {}, ...rows));
}
