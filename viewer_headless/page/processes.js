// SPDX-License-Identifier: BSD-3-Clause
// How each process is: state, what a frame takes it, what waits for it, how often it was started again.
import { byId, element } from "./element.js";
import { count, fixed, median } from "./format.js";

// A process says how it is once a second.
const kSilent_s = 4;
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

/** What a frame (of mapping: an update of the map) takes, in words. */
function work(run, name) {
  if (name.startsWith("vo") && run.rows) return `${fixed(median(newestTotals(run.frames.stages_ms, run.frameWidths.stages_ms, run.stageNames)), 1)} ms a frame`;
  if (name.startsWith("mapping") && run.mapTimes.stages_ms?.length) {
    return `${fixed(median(newestTotals(run.mapTimes.stages_ms, run.mapStageNames.length, run.mapStageNames)), 1)} ms an update`;
  }
  return null;
}

function last(values) {
  const finite = Array.from(values ?? []).filter(Number.isFinite);
  return finite.at(-1);
}

/** Messages that wait for a process, over all its queues; null where it has none. */
function waiting(table) {
  const queues = Object.keys(table).filter((name) => name.startsWith("queue."));
  return queues.length ? queues.reduce((sum, name) => sum + (last(table[name]) ?? 0), 0) : null;
}

export function showProcesses(run) {
  byId("processes").hidden = run.processes.length === 0;
  const now = Math.max(0, ...run.processes.map((p) => p.heard_s));
  byId("process-list").replaceChildren(...run.processes.map((p) => {
    const silent = !run.facts.finished && now - p.heard_s > kSilent_s;
    const state = silent ? `silent for ${count(now - p.heard_s)} s` : p.state;
    const bad = silent || p.state === "failed";
    const queue = waiting(p.table);
    const facts = [
      work(run, p.name),
      queue === null ? null : `queue ${count(queue)}`,
      `${p.restarts} ${p.restarts === 1 ? "restart" : "restarts"}`,
    ];
    return element("li", { "data-process": p.name, class: bad ? "bad" : p.restarts ? "restarted" : p.state },
      element("b", {}, p.name), element("span", { class: "state" }, state), element("small", {}, facts.filter(Boolean).join(" · ")));
  }));
}
