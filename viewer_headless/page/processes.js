// SPDX-License-Identifier: BSD-3-Clause
// How each process is: how far it is behind, what a frame takes it, what waits for it, how often it was started again.
import { byId, element } from "./element.js";
import { count, fixed, median } from "./format.js";

// As many of the newest frames or updates tell what one takes.
const kNewest = 50;

function newestTotals(values, width, names) {
  const rows = width ? Math.floor(values.length / width) : 0;
  const total = names.indexOf("total");
  return Array.from({ length: Math.min(kNewest, rows) }, (_, i) => {
    const row = Array.from(values.subarray((rows - 1 - i) * width, (rows - i) * width)).filter((_, k) => total < 0 || k === total);
    return row.filter(Number.isFinite).reduce((sum, ms) => sum + ms, 0);
  });
}

/** Time on a processor between the first and the last row. One that was started again counts from 0. */
export function cpuTime_s(cpu_s) {
  return cpu_s.reduce((sum, now, i) => sum + (i ? Math.max(0, now - cpu_s[i - 1]) : 0), 0);
}

/** What a frame (of mapping: an update of the map) takes; of other processes their time on a processor for each frame. */
function work(run, { name, table }) {
  if (name.startsWith("vo") && run.rows) return `${fixed(median(newestTotals(run.frames.stages_ms, run.frameWidths.stages_ms, run.stageNames)), 1)} ms`;
  if (name.startsWith("mapping") && run.mapTimes.stages_ms?.length) {
    return `${fixed(median(newestTotals(run.mapTimes.stages_ms, run.mapStageNames.length, run.mapStageNames)), 1)} ms an update`;
  }
  const first = Math.max(0, table.frame.findIndex((frame) => frame >= 0));
  const frames = table.frame.at(-1) - table.frame[first];
  return frames > 0 ? `${fixed((1000 * cpuTime_s(table.cpu_s.subarray(first))) / frames, 1)} ms of CPU` : "–";
}

/** Frames that a process is behind, and how much of the recording that is. */
function lag(run, frames) {
  if (frames === null || run.facts.finished) return "–";
  const t = run.frames.t_s;
  const period_s = run.rows > 1 ? (t[run.rows - 1] - t[0]) / (run.frames.id[run.rows - 1] - run.frames.id[0]) : NaN;
  return `${count(frames)} ${frames === 1 ? "frame" : "frames"}${frames && period_s > 0 ? ` (${fixed(frames * period_s, 2)} s)` : ""}`;
}

/** [what is said, how it looks]. A process of a run that is over has nothing left to do, whatever it said last. */
function stateOf(run, p) {
  if (p.state === "failed") return ["failed", "bad"];
  if (run.facts.finished) return ["ended", "finished"];
  if (p.pace === "silent" || p.pace === "gone") return [p.state === "stopping" ? p.state : `silent for ${count(p.silent_s)} s`, "bad"];
  return [p.pace === "behind" ? `${p.state}, behind` : p.state, p.pace === "behind" || p.restarts ? "restarted" : p.state];
}

const kColumns = ["process", "state", "lag", "a frame takes", "waiting", "restarts"];

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
