// SPDX-License-Identifier: BSD-3-Clause
// The decoded data of a run as written by the viewer: columns become typed arrays. A live page appends later data.

import { unpackObservers } from "./observers.js";

const kArrays = { f32: Float32Array, i32: Int32Array, u16: Uint16Array, u8: Uint8Array };

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

export function decodeTable(table) {
  const columns = {};
  for (const [name, { type, data }] of Object.entries(table ?? {})) columns[name] = new kArrays[type](bytesOf(data).buffer);
  return columns;
}

function widthsOf(table) {
  return Object.fromEntries(Object.entries(table).map(([name, column]) => [name, column.width]));
}

/** Appends `more` to the first `rows` rows of `table`; `width`: numbers per row, before and now. */
function append(table, oldWidths, more, widths, rows) {
  const result = {};
  for (const [name, column] of Object.entries(more)) {
    const width = widths[name];
    const moreRows = column.length / width;
    const joined = new column.constructor((rows + moreRows) * width);
    if (joined instanceof Float32Array) joined.fill(NaN);
    const old = table[name];
    const oldWidth = oldWidths[name] ?? width;
    // New stages make the rows wider.
    for (let row = 0; old && row < rows; ++row) {
      joined.set(old.subarray(row * oldWidth, row * oldWidth + Math.min(width, oldWidth)), row * width);
    }
    joined.set(column, rows * width);
    result[name] = joined;
  }
  return result;
}

export class Run {
  constructor() {
    this.facts = {};
    this.next = "";
    this.frames = {};
    this.frameWidths = {};
    this.path = null;
    this.map = null;
    this.surfaces = null;
    this.stageNames = [];
    this.mapStageNames = [];
    this.mapTimes = {};
    this.loops = [];
    this.corrections = [];
    this.processes = [];
    this.pictures = [];
    this.notes = [];
    this.packedObservers = null;
    this.observersKnown = false;
    this.observers = {};
  }

  get rows() {
    return this.frames.id?.length ?? 0;
  }

  /** Reads the viewer's JSON; returns the names of the changed parts. */
  take(json) {
    const changed = new Set(["facts", "processes"]);
    if (json.whole) Object.assign(this, new Run());
    // Figures that are sent only with the path are kept until the next path.
    const kept = json.path ? {} : {
      ate_m: this.facts.ate_m, live_ate_m: this.facts.live_ate_m, length_m: this.facts.length_m, warnings: this.facts.warnings,
    };
    this.facts = { ...json.facts, ...kept };
    this.next = json.next;
    this.stageNames = json.stage_names;
    const widths = widthsOf(json.frames);
    const decoded = decodeTable(json.frames);
    this.frames = append(this.frames, this.frameWidths, decoded, widths, Math.min(json.first_row, this.rows));
    this.frameWidths = widths;
    if (json.whole || decoded.id.length) changed.add("frames");
    this.processes = json.processes.map((p) => ({ ...p, table: decodeTable(p.table) }));
    this.takePictures(json.pictures);
    if (json.pictures.length) changed.add("pictures");
    if (json.surfaces) {
      changed.add("surfaces");
      this.surfaces = { ...json.surfaces, points: decodeTable(json.surfaces.points) };
    }
    if (!json.path) return changed;
    changed.add("map");
    this.path = decodeTable(json.path);
    const { vertical, observers, ...tables } = json.map;
    this.map = Object.fromEntries(Object.entries(tables).map(([name, table]) => [name, decodeTable(table)]));
    this.map.vertical = vertical ?? { up: [0, -1, 0], from: "cameras" };
    this.packedObservers = observers ?? null;
    this.observersKnown = !!observers && !observers.only_ids;
    this.observers = {};
    this.mapStageNames = json.map_stage_names;
    this.mapTimes = decodeTable(json.map_times);
    this.loops = json.loops;
    this.corrections = json.corrections.map((c) => ({ ...c, table: decodeTable(c.table) }));
    this.notes = json.notes;
    return changed;
  }

  takePictures(pictures) {
    const known = new Set(this.pictures.map((p) => p.frame));
    for (const picture of pictures) {
      if (known.has(picture.frame)) continue;
      this.pictures.push({ ...picture, features: decodeTable(picture.features) });
    }
    this.pictures.sort((a, b) => a.frame - b.frame);
  }

  /** Returns the ids of the landmarks ("points" or "segments") and, if known (`observersKnown`), their observations;
   * unpacked on the first call. null if there is neither. */
  observersOf(type) {
    if (!this.packedObservers) return null;
    return (this.observers[type] ??= unpackObservers(bytesOf(this.packedObservers[type])));
  }

  /** Returns the last row whose frame is not after `frame`; 0 if there is none. */
  rowOf(frame) {
    return Math.max(0, countUpTo(this.frames.id ?? [], frame) - 1);
  }

  /** Returns the last row that is not after `t_s`. */
  rowAt(t_s) {
    return Math.max(0, countUpTo(this.frames.t_s ?? [], t_s) - 1);
  }

  /** Returns the position in the final map if it is known, else the published one. */
  position(row, out) {
    const known = this.path && 3 * row + 2 < this.path.p.length;
    const from = known ? this.path.p : this.frames.live;
    for (let k = 0; k < 3; ++k) out[k] = from[3 * row + k];
    return out;
  }
}

/** Returns how many of the ascending `values` are not above `limit`. */
export function countUpTo(values, limit) {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= limit) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Returns other runs of the same dataset, written into the page by `evaluate compare --map`: the name of its own
 * run, the address of the page that compares them, if there is one, and the runs in the format of others.js. */
export function embeddedOthers() {
  const found = JSON.parse(document.getElementById("other-runs").textContent);
  return Array.isArray(found?.others) ? found : { name: "", comparison: "", others: [] };
}

/** Returns the data in the page; null in a live page. Its warnings are those of `plslam run`, which evaluated the
 * run. */
export function embeddedData() {
  const [data, warnings] = ["run-data", "run-warnings"].map((id) => JSON.parse(document.getElementById(id).textContent));
  if (data && Array.isArray(warnings)) data.facts.warnings = warnings;
  return data;
}
