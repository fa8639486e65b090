// SPDX-License-Identifier: BSD-3-Clause
// The data of each plot, from the data of the run. A row is {key, spec, data}; plots without data are omitted.
import { series as colours } from "./colours.js";
import { countUpTo } from "./data.js";

const kTop = 7;
const kLeastInterval_s = 0.5;

const numbers = (column) => Array.from(column, (v) => (Number.isFinite(v) ? v : null));
const any = (values) => values.some((v) => v !== null && v !== 0);

function onlyWithNumbers(plots) {
  return plots.filter(Boolean).filter((p) => p.data[0].length > 1 && p.data.slice(1).some(any));
}

function errors(run, t) {
  if (!run.path?.error_m) return [];
  const fill = (column) => {
    const values = numbers(column);
    while (values.length < t.length) values.push(null);
    return values;
  };
  return [
    {
      key: "error",
      spec: { title: "Error of position", unit: "m", range: (_, low, high) => [0, high * 1.08 || 1],
        series: [{ label: "in the final map", colour: colours[0], fill: "#4c8dde22" }, { label: "as published", colour: colours[1], width: 1.1 }] },
      data: [t, fill(run.path.error_m), fill(run.path.live_error_m)],
    },
    {
      key: "rotation",
      spec: { title: "Error of orientation", unit: "deg", range: (_, low, high) => [0, high * 1.08 || 1],
        series: [{ label: "in the final map", colour: colours[0], fill: "#4c8dde22" }] },
      data: [t, fill(run.path.error_deg)],
    },
  ];
}

function tracked(run, t) {
  const f = run.frames;
  return {
    key: "tracked",
    spec: { title: "Features tracked", unit: "per frame", range: (_, low, high) => [0, high * 1.08 || 1],
      series: [{ label: "points", colour: colours[0] }, { label: "lines", colour: colours[1] },
        { label: "points found", colour: colours[0], dash: [3, 4], width: 1 }, { label: "lines found", colour: colours[1], dash: [3, 4], width: 1 }] },
    data: [t, numbers(f.tracked_points), numbers(f.tracked_lines), numbers(f.points), numbers(f.lines)],
  };
}

function entropy(run, t) {
  const f = run.frames;
  const ratio = Array.from(f.entropy_ratio, (v) => (v > 0 && Number.isFinite(v) ? v : null));
  const made = ratio.map((v, i) => (f.keyframe[i] ? v ?? 1 : null));
  return {
    key: "entropy",
    spec: { title: "Entropy ratio", note: "of the motion since the last keyframe; below 0.9 a new one is made", unit: "ratio",
      series: [{ label: "ratio", colour: colours[2] }, { label: "0.9", colour: colours[6], dash: [6, 4], width: 1 },
        { label: "keyframe", colour: colours[3], points: true }] },
    data: [t, ratio, t.map(() => 0.9), made],
  };
}

/** Stacks stages, the largest at the bottom; small ones are summed up. */
function stacked(key, title, note, x, names, values, width) {
  const parts = names.map((name, i) => ({ name, values: x.map((_, row) => (Number.isFinite(values[row * width + i]) ? values[row * width + i] : 0)) }))
    .filter((p) => p.name !== "total");
  for (const part of parts) part.sum = part.values.reduce((a, b) => a + b, 0);
  parts.sort((a, b) => b.sum - a.sum);
  const rest = parts.splice(kTop - 1);
  if (rest.length > 1) parts.push({ name: "other", values: x.map((_, row) => rest.reduce((sum, p) => sum + p.values[row], 0)) });
  else parts.push(...rest);
  let below = x.map(() => 0);
  const tops = parts.map((part) => (below = below.map((b, row) => b + part.values[row])));
  // uPlot draws series in order: the highest first, so that the lower ones cover it.
  const order = parts.map((_, i) => parts.length - 1 - i);
  return {
    key,
    spec: { title, note, unit: "ms", range: (_, low, high) => [0, high * 1.05 || 1],
      series: order.map((i) => ({ label: parts[i].name, colour: colours[i % colours.length], fill: colours[i % colours.length], width: 0.5, own: parts[i].values })) },
    data: [x, ...order.map((i) => tops[i])],
  };
}

function odometryStages(run, t) {
  return stacked("stages", "Odometry, by stage", "time of each frame", t, run.stageNames, run.frames.stages_ms, run.frameWidths.stages_ms);
}

function mappingStages(run, t) {
  const frames = run.mapTimes.frame;
  if (!frames?.length) return null;
  const x = Array.from(frames, (frame) => t[Math.max(0, countUpTo(run.frames.id, frame) - 1)]);
  // Several updates may arrive within a frame, but the axis needs increasing times.
  for (let i = 1; i < x.length; ++i) x[i] = Math.max(x[i], x[i - 1] + 1e-4);
  return stacked("mapping", "Mapping, by stage", "time of each update of the map", x, run.mapStageNames, run.mapTimes.stages_ms, run.mapStageNames.length);
}

/** Makes one series for each process, on one axis of wall time. `value(table, i)` is its number at sample i. */
function byProcess(run, key, spec, value) {
  const rows = run.processes.map((p) => ({ name: p.name, t: p.table.t_s, values: value(p.table) })).filter((r) => r.values?.some((v) => v > 0));
  if (!rows.length) return null;
  return joined(key, spec, rows.map((r) => ({ label: r.name, t: r.t, values: r.values })));
}

/** Joins series with different times on one axis; between its samples a series keeps its value. */
function joined(key, spec, rows) {
  const times = [...new Set(rows.flatMap((r) => [...r.t]))].sort((a, b) => a - b);
  const columns = rows.map((r) => times.map((t) => {
    const i = countUpTo(r.t, t) - 1;
    return i < 0 || !Number.isFinite(r.values[i]) ? null : r.values[i];
  }));
  const series = rows.map((r, i) => ({ label: r.label, colour: colours[i % colours.length], steps: true }));
  return { key, wall: true, spec: { xLabel: "time since the start in s", range: (_, low, high) => [0, high * 1.08 || 1], ...spec, series }, data: [times, ...columns] };
}

function queues(run) {
  const rows = run.processes.flatMap((p) => Object.keys(p.table).filter((name) => name.startsWith("queue."))
    .map((name) => ({ label: `${p.name}: ${name.slice(6)}`, t: p.table.t_s, values: p.table[name] })));
  return rows.length ? joined("queues", { title: "Queues", note: "messages waiting for a process", unit: "waiting" }, rows) : null;
}

function repairs(run) {
  const rows = ["lost", "repaired", "resent", "rejected", "skipped"].map((name) => {
    const all = run.processes.filter((p) => p.table[`bus.${name}`]).map((p) => ({ t: p.table.t_s, values: p.table[`bus.${name}`] }));
    const t = [...new Set(all.flatMap((r) => [...r.t]))].sort((a, b) => a - b);
    const at = (r, time) => r.values[Math.max(0, countUpTo(r.t, time) - 1)] || 0;
    return { label: name, t, values: t.map((time) => all.reduce((sum, r) => sum + at(r, time), 0)) };
  }).filter((r) => r.t.length);
  return rows.length ? joined("repairs", { title: "Messages lost and repaired", note: "sums over all processes", unit: "messages" }, rows) : null;
}

/** Returns the use of a core in per cent at each sample, over at least half a second by the clock of the process: a
 * status that follows a change of state comes milliseconds after the previous one, and a busy viewer receives several at
 * once. */
export function coreUse_percent({ uptime_s, cpu_s }) {
  let start = 0; // of the present process: a restarted one counts from 0
  return Array.from(cpu_s, (now_s, i) => {
    if (i && uptime_s[i] < uptime_s[i - 1]) start = i;
    let before = i;
    while (before >= start && uptime_s[before] > uptime_s[i] - kLeastInterval_s) --before;
    const [since_s, used_s] = before >= start ? [uptime_s[before], cpu_s[before]] : [0, 0];
    const interval_s = uptime_s[i] - since_s;
    return interval_s >= kLeastInterval_s ? (100 * (now_s - used_s)) / interval_s : 0;
  });
}

function processors(run) {
  return byProcess(run, "cpu", { title: "Processor", unit: "% of a core" }, coreUse_percent);
}

function memory(run) {
  return byProcess(run, "memory", { title: "Memory", unit: "MB" }, ({ memory_mb }) => [...memory_mb]);
}

export function plotsOf(run) {
  if (!run.rows) return [];
  const t = Array.from(run.frames.t_s);
  // Times that do not increase (a stream played again) would fold the plots.
  for (let i = 1; i < t.length; ++i) t[i] = Math.max(t[i], t[i - 1] + 1e-6);
  // These plots are also useful if all values are 0.
  const always = new Set(["repairs", "queues"]);
  const all = [...errors(run, t), tracked(run, t), entropy(run, t), odometryStages(run, t), mappingStages(run, t), queues(run), repairs(run), processors(run), memory(run)];
  const kept = new Set(onlyWithNumbers(all));
  return all.filter((p) => p && (kept.has(p) || (always.has(p.key) && p.data[0].length > 1)));
}
