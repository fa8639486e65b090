// SPDX-License-Identifier: BSD-3-Clause
// node --test data_test.mjs: tests how a page joins the data that the viewer sends in parts.
import assert from "node:assert/strict";
import { test } from "node:test";
import { countUpTo, Run } from "../../viewer_headless/page/data.js";
import { fitView, worthSeeing } from "../../viewer_headless/page/framing.js";
import { unpackObservers, unpackSigma } from "../../viewer_headless/page/observers.js";
import { WallClock } from "../../viewer_headless/page/wall_clock.js";
import { counted, observedBy } from "../../viewer_headless/page/format.js";
import { coreUse_percent } from "../../viewer_headless/page/plot_data.js";
import { matchBlocks } from "../../viewer_headless/page/disparity.js";
import { cpuTime_s } from "../../viewer_headless/page/processes.js";
import { refinementRows } from "../../viewer_headless/page/refinement.js";
import { notTracked } from "../../viewer_headless/page/summary.js";

function column(Type, name, width, values) {
  return { type: name, width, data: Buffer.from(Type.from(values).buffer).toString("base64") };
}
const f32 = (width, values) => column(Float32Array, "f32", width, values);
const i32 = (values) => column(Int32Array, "i32", 1, values);

function message(more) {
  return { facts: { dataset: "d", finished: false }, next: "n", whole: false, stage_names: [], map_stage_names: [], first_row: 0,
    frames: { id: i32([]), t_s: f32(1, []), stages_ms: f32(1, []) }, path: null, map: null, map_times: {}, loops: [],
    corrections: [], processes: [], pictures: [], notes: [], ...more };
}
const rows = (ids, width, stages) => ({ id: i32(ids), t_s: f32(1, ids.map((id) => id / 10)), stages_ms: f32(width, stages) });

test("frames are put behind each other", () => {
  const run = new Run();
  run.take(message({ whole: true, frames: rows([0, 1], 1, [5, 6]) }));
  run.take(message({ first_row: 2, frames: rows([2], 1, [7]) }));
  assert.deepEqual([...run.frames.id], [0, 1, 2]);
  assert.deepEqual([...run.frames.stages_ms], [5, 6, 7]);
  run.take(message({ first_row: 3 }));
  assert.equal(run.rows, 3);
});

test("what did not come has not changed", () => {
  const run = new Run();
  assert.ok(run.take(message({ whole: true, frames: rows([0], 1, [5]) })).has("frames"));
  assert.ok(!run.take(message({ first_row: 1 })).has("frames"));
  assert.ok(run.take(message({ first_row: 1, frames: rows([1], 1, [5]) })).has("frames"));
  assert.ok(run.take(message({ whole: true })).has("frames"), "another run has none yet");
});

test("surfaces stay until there are new ones", () => {
  const run = new Run();
  const u8 = (width, values) => column(Uint8Array, "u8", width, values);
  const surfaces = { points: { grey: u8(1, [7, 8]) }, low_w: [0, 0, 0], step_m: 1, spacing_m: 0.05, grid: null };
  assert.ok(!run.take(message({ whole: true, frames: rows([0], 1, [5]) })).has("surfaces"));
  assert.ok(run.take(message({ first_row: 1, surfaces })).has("surfaces"));
  assert.ok(!run.take(message({ first_row: 1, surfaces: null })).has("surfaces"));
  assert.deepEqual([...run.surfaces.points.grey], [7, 8]);
});

test("a stage that nobody knew of makes rows wider", () => {
  const run = new Run();
  run.take(message({ whole: true, stage_names: ["a"], frames: rows([0, 1], 1, [5, 6]) }));
  run.take(message({ first_row: 2, stage_names: ["a", "b"], frames: rows([2], 2, [7, 8]) }));
  assert.deepEqual([...run.frames.stages_ms], [5, NaN, 6, NaN, 7, 8]);
});

test("another run begins anew, figures of the path stay until the next path", () => {
  const run = new Run();
  const path = { p: f32(3, [1, 2, 3]), q: f32(4, [0, 0, 0, 1]) };
  const map = { points: {}, segments: {}, keyframes: {}, edges: {}, loop_edges: {} };
  run.take(message({ whole: true, facts: { ate_m: 0.5, length_m: 3 }, frames: rows([0], 1, [5]), path, map }));
  run.take(message({ first_row: 1, facts: { ate_m: null, length_m: 0 }, frames: rows([1], 1, [5]) }));
  assert.equal(run.facts.ate_m, 0.5);
  assert.deepEqual(run.position(0, [0, 0, 0]), [1, 2, 3]);
  run.take(message({ whole: true, frames: rows([7], 1, [5]) }));
  assert.deepEqual([...run.frames.id], [7]);
  assert.equal(run.path, null);
});

test("one is singular", () => {
  assert.deepEqual([0, 1, 2].map((n) => counted(n, "frame")), ["0 frames", "1 frame", "2 frames"]);
  assert.deepEqual([1, 3, 255].map(observedBy), ["1 keyframe", "3 keyframes", "255 keyframes or more"]);
});

test("the use of a core is measured over half a second or more", () => {
  // The fifth status follows the fourth one at once, and another process takes over after it.
  const use = coreUse_percent({ uptime_s: [0.1, 0.101, 1.1, 2.1, 2.101, 0.2, 1.2], cpu_s: [0.02, 0.05, 0.55, 1.55, 1.58, 0.1, 0.3] });
  assert.deepEqual(use.map(Math.round), [0, 0, 50, 100, 103, 0, 20]);
});

test("rows are found by frame and by time", () => {
  const run = new Run();
  run.take(message({ whole: true, frames: rows([0, 10, 20], 1, [1, 1, 1]) }));
  assert.deepEqual([-5, 0, 9, 10, 99].map((frame) => run.rowOf(frame)), [0, 0, 0, 1, 2]);
  assert.equal(run.rowAt(1.5), 1);
  assert.equal(new Run().rowOf(3), 0);
  assert.equal(countUpTo([1, 1, 2], 1), 2);
});

test("pictures come once, in order", () => {
  const run = new Run();
  const picture = (frame) => ({ frame, features: {} });
  run.take(message({ whole: true, pictures: [picture(4), picture(2)] }));
  run.take(message({ pictures: [picture(4), picture(3)] }));
  assert.deepEqual(run.pictures.map((p) => p.frame), [2, 3, 4]);
});

test("far landmarks are not worth seeing, the whole path is", () => {
  const path = [-5, 0, 0, 5, 0, 0];
  const landmarks = new Float64Array(300 * 3).map((_, i) => (i % 3 === 0 ? (i / 3) % 10 : 0));
  landmarks.set([900, 0, 0, 0, 700, 0, 0, 0, -800]);
  const seen = worthSeeing(path, landmarks);
  assert.deepEqual(seen.slice(0, 6), path);
  assert.ok(Math.max(...seen.map(Math.abs)) < 10, `up to ${Math.max(...seen.map(Math.abs))}`);
  assert.ok(seen.length > 0.8 * 900, "and most of the landmarks");
  assert.equal(worthSeeing([], new Float64Array()).length, 6, "something where there is nothing");
  const near = worthSeeing([0, 0, 0, 1, 0, 0], Float64Array.from([0, 0, 2, 0, 0, 500, 0, 0, 500, 0, 0, 500]));
  assert.ok(Math.max(...near) < 10, "nor are those that are all far, for then the path would be a dot");
});

test("the nearest eye that sees all points has two of them at the border", () => {
  let random = 1;
  const points = Array.from({ length: 300 }, () => ((random = (random * 48271) % 2147483647) / 2147483647) * 20 - 3);
  const tangents = [0.8, 0.4];
  for (const direction of [[0, 1, 0.001], [-0.35, 0.75, 0.8]]) {
    const { target, distance } = fitView(points, direction, [0, 1, 0], tangents);
    const length = Math.hypot(...direction);
    const z = direction.map((v) => v / length);
    const x = [z[2] / Math.hypot(z[0], z[2]), 0, -z[0] / Math.hypot(z[0], z[2])];
    const y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
    let [mostX, mostY] = [0, 0];
    for (let i = 0; i < points.length; i += 3) {
      const p = [0, 1, 2].map((k) => points[i + k] - target[k]);
      const along = (axis) => p.reduce((sum, v, k) => sum + v * axis[k], 0);
      const depth = distance - along(z);
      mostX = Math.max(mostX, Math.abs(along(x)) / depth / tangents[0]);
      mostY = Math.max(mostY, Math.abs(along(y)) / depth / tangents[1]);
    }
    assert.ok(mostX <= 0.9201 && mostY <= 0.9201 && Math.max(mostX, mostY) > 0.9199, `${mostX}, ${mostY}`);
  }
});

test("landmarks of a long run have ids alone", () => {
  const run = new Run();
  const observers = { points: Buffer.from([4, 0, 169, 2, 0]).toString("base64"), segments: "", only_ids: true };
  const map = { points: {}, segments: {}, keyframes: {}, edges: {}, loop_edges: {}, observers };
  run.take(message({ whole: true, frames: rows([0], 1, [5]), path: { p: f32(3, [1, 2, 3]), q: f32(4, [0, 0, 0, 1]) }, map }));
  assert.deepEqual(run.observersOf("points"), { ids: [3, 300], starts: [0, 0, 0], rows: [] });
  assert.ok(!run.observersKnown);
});

test("observers are unpacked as they were packed", () => {
  // PackObservers.IdsCountsAndRows in report_tables_test.cpp packs the same data.
  const bytes = [4, 3, 10, 1, 171, 2, 169, 2, 1, 0, 1, 0];
  assert.deepEqual(unpackObservers(bytes), { ids: [3, 300, 301], starts: [0, 3, 4, 4], rows: [5, 6, 305, 5] });
  assert.deepEqual(unpackObservers([4, 1, 12, 169, 2, 1, 7]).rows, [6, 2]);
  assert.ok(Number.isNaN(unpackSigma(0)));
  assert.ok(Math.abs(unpackSigma(101) - 1e-4 * 1.05 ** 100) < 1e-9);
});

test("the clock of the host follows that of the recording", () => {
  const run = new Run();
  const table = { t_s: f32(1, [0, 1, 2, 3, 4]), frame: i32([-1, 0, 10, 20, 20]) };
  run.take(message({ whole: true, frames: rows([0, 10, 20], 1, [1, 1, 1]), processes: [{ name: "vo", state: "running", table }] }));
  const clock = new WallClock(run);
  assert.equal(clock.timeAt(1.5), 0.5);
  assert.equal(clock.wallAt(1.5), 2.5);
  assert.deepEqual([clock.timeAt(0), clock.timeAt(9), clock.wallAt(-1), clock.wallAt(9)], [0, 2, 1, 3]);
  assert.equal(new WallClock(new Run()).timeAt(1), null);
});

test("a process that was started again has used the time of both", () => {
  assert.equal(cpuTime_s(Float32Array.of(1, 4, 6, 0.5, 2.5)), 7);
  assert.equal(cpuTime_s(Float32Array.of(3)), 0);
});

test("a pattern has its disparity, a fence, whose posts are all alike, has none", () => {
  const [width, height, shift] = [64, 24, 5];
  const matched = (right) => {
    const left = right.map((_, i) => right[i - Math.min(shift, i % width)]);
    return matchBlocks(left, right, width, height, 20).filter((_, i) => i % width > 26 && i % width < width - 8);
  };
  let random = 1;
  const pattern = matched(new Uint8Array(width * height).map(() => (random = (random * 48271) % 2147483647) & 255));
  assert.ok(pattern.every((d) => Math.abs(d - shift) < 0.3), `${pattern}`);
  const fence = matched(new Uint8Array(width * height).map((_, i) => ((i % width) % 8 < 4 ? 200 : 50)));
  assert.ok(fence.every(Number.isNaN), `${fence}`);
});

test("frames that are not tracked are told by what became of them", () => {
  const none = { initialising_frames: 0, lost_frames: 0, skipped_frames: 0, bad_frames: 0, unanswered_frames: 0 };
  assert.equal(notTracked(none), "none lost");
  assert.equal(notTracked({ ...none, initialising_frames: 90 }), "90 initialising");
  assert.equal(notTracked({ ...none, lost_frames: 2, skipped_frames: 3, bad_frames: 4, unanswered_frames: 5 }),
    "2 lost, 3 skipped, 4 unreadable, 5 unanswered");
});

test("warnings come with the path, and stay until the next", () => {
  const run = new Run();
  const path = { p: f32(3, [0, 0, 0]), q: f32(4, [0, 0, 0, 1]) };
  const map = { points: {}, segments: {}, keyframes: {}, edges: {}, loop_edges: {} };
  run.take(message({ whole: true, facts: { warnings: [{ sentence: "dark" }] }, frames: rows([0], 1, [5]), path, map }));
  run.take(message({ first_row: 1, facts: { warnings: [] }, frames: rows([1], 1, [5]) }));
  assert.equal(run.facts.warnings.length, 1);
  run.take(message({ first_row: 2, facts: { warnings: [] }, path, map }));
  assert.equal(run.facts.warnings.length, 0);
});

test("a refinement has a row for each figure of both maps and for each parameter of the camera", () => {
  const map = { points: 1200, lines: 30, rms_points_px: 0.7, loops: 0, rms_loops_m: 0, length_m: 10 };
  const camera = [{ name: "focal length", unit: "px", state: "estimated", value: 4.1, sigma: 1 },
    { name: "principal point x", unit: "px", state: "not determined", value: 0, sigma: null }];
  const rows = refinementRows({ before: map, after: { ...map, length_m: 9.5 }, camera });
  assert.deepEqual(rows.map(([name]) => name), ["Points", "Segments", "Residual of points (rms)", "Loops", "Length along keyframes",
    "Camera: focal length", "Camera: principal point x"]);
  assert.deepEqual(rows[4].slice(1), ["10.000 m", "9.500 m"]);
  assert.deepEqual(rows[5].slice(1), ["", "4.1000 px, sigma 1.0000"]);
  assert.equal(rows[6][2], "not determined");
  const withLoops = { ...map, loops: 2, rms_loops_m: 0.01 };
  assert.equal(refinementRows({ before: withLoops, after: withLoops, camera: [] }).length, 6);
});
