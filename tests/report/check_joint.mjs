// SPDX-License-Identifier: BSD-3-Clause
// node check_joint.mjs CHROMEDRIVER CHROMIUM PAGE.html: opens a report with the map of another run, and checks that
// both are visible, one on the other, and can be switched. Exit code 1 on failure.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, kShift } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);
/** Checks that a table lists both runs. */
async function checkTable() {
  const [rows, facts] = await browser.run(`
    const text = (cell) => cell.childNodes[0].textContent;
    const rows = [...document.querySelectorAll("#run-table tbody tr")].map((row) =>
      Object.fromEntries([...row.querySelectorAll("[data-name]")].map((cell) => [cell.dataset.name, text(cell) + " " + cell.textContent])));
    return [rows, [plslam.run, ...plslam.run.others].map(({ facts }) => facts)];`);
  check.that(rows.length === 2, `a row for each run: ${rows.length}`);
  rows.forEach((row, i) => {
    const told = row.Frames.startsWith(`${facts[i].all_frames} `) && row.Path.includes(`${facts[i].keyframes} keyframe`) &&
      row.Map.includes(`${facts[i].lines} segment`) && /mm|cm/.test(row["Error (ATE)"]);
    check.that(told, `with frames, keyframes, landmarks and error: ${JSON.stringify(row)}`);
  });
  check.that(facts[0].lines > 0 && facts[1].lines === 0, `of each run its own: ${facts.map((f) => f.lines)} segments`);
}

/** Checks that the switch of a run hides all of it and nothing of the other; those of landmarks and path are for both. */
async function checkSwitches(page) {
  for (const layer of ["keyframes", "loopEdges", "truth"]) await page.click(`[name=${layer}]`);
  await page.settle();
  const both = await page.look("#map", ["other0", "path"]);
  check.that(both.near.other0 > 500, `the other run is seen: ${both.near.other0} pixels of its colour`);
  await page.switch("own", false);
  const other = await page.look("#map", ["other0", "path"]);
  check.that(other.near.other0 > 0.8 * both.near.other0, `the other stays: ${both.near.other0} pixels, then ${other.near.other0}`);
  check.that(both.near.path > 100 && other.near.path < 0.2 * both.near.path && other.colours < 0.6 * both.colours,
    `one switch hides the first run: ${other.near.path} of ${both.near.path} pixels of its path, ${other.colours} of ${both.colours} colours left`);
  await page.click("[name=points]");
  await page.switch("segments", false);
  const path = await page.look("#map", ["other0"]);
  check.that(path.near.other0 > 150 && path.near.other0 < other.near.other0, `landmarks and path: without landmarks ${path.near.other0} pixels`);
  await page.switch("other0", false);
  const none = await page.look("#map", ["other0"]);
  check.that(none.near.other0 < 0.2 * path.near.other0, `its switch hides it: ${none.near.other0} pixels left`);
  for (const layer of ["own", "points", "segments", "other0"]) await page.click(`[name=${layer}]`);
  await page.settle();
  const labels = await page.text("#layers");
  check.that(/Runs.*out.*out/s.test(labels), `both runs have a name: '${labels}'`);
}

/** Checks that landmarks of both runs can be clicked, and distances between them measured. */
async function checkPick(page) {
  const own = await page.findPickable("points");
  const other = await page.findPickable("points", 1);
  check.that(own.row >= 0 && other.row >= 0, "points of both can be clicked");
  await browser.press(other.at);
  const label = await browser.run("return plslam.run.others[0].label");
  const [id, observations] = await browser.run("const run = plslam.run.others[0]; return [run.observersOf('points').ids[arguments[0]], run.map.points.observations[arguments[0]]]", other.row);
  const text = await page.text("#picked");
  check.that(text.includes(`Point ${id}`) && text.includes(label) && text.includes(`${observations} keyframe`), `one of the other run: '${text}'`);
  await browser.press(own.at, own.at, 1, kShift);
  const [length, wanted] = await browser.run(`
    const { run, view } = plslam;
    const other = run.others[0];
    const e = other.transform.elements, q = other.map.points.p.subarray(3 * arguments[1]), p = run.map.points.p.subarray(3 * arguments[0]);
    const moved = [0, 1, 2].map((k) => e[k] * q[0] + e[4 + k] * q[1] + e[8 + k] * q[2] + e[12 + k]);
    return [view.parts.selection.length(), Math.hypot(...moved.map((x, k) => x - p[k]))];`, own.row, other.row);
  check.that(Math.abs(length - wanted) < 1e-4, `and the distance between both: ${length} of ${wanted} m`);
  const { pick } = await page.address();
  check.that(pick === `points:${id}@1`, `which the address tells: ${pick}`);
}

/** Checks that the page of the comparison and this one are linked. */
async function checkLinks() {
  await browser.run("document.getElementById('comparison').click()");
  await browser.until("return document.title === 'Comparison of runs'", "the comparison");
  await browser.run("document.querySelector('a').click()");
  await browser.until("return !!window.plslam && window.plslam.run.others?.length === 1", "the map again");
}

await runChecks(check, browser, async (page) => {
  await page.open(pathToFileURL(resolve(file)).href);
  await checkTable();
  await checkSwitches(page);
  // The truth joins the two maps, so their paths coincide.
  const apart = await browser.run(`
    const other = plslam.view.parts.others.runs[0], own = plslam.run;
    const p = [0, 0, 0];
    let largest = 0;
    for (let row = 0; row < own.rows; ++row) {
      own.position(row, p);
      const e = other.group.matrix.elements, q = other.run.path.p.slice(3 * row, 3 * row + 3);
      if (![...p, ...q].every(Number.isFinite)) continue;
      const moved = [0, 1, 2].map((k) => e[k] * q[0] + e[4 + k] * q[1] + e[8 + k] * q[2] + e[12 + k]);
      largest = Math.max(largest, Math.hypot(...moved.map((x, k) => x - p[k])));
    }
    return largest;`);
  check.that(apart < 0.2, `the paths are at most ${apart.toFixed(3)} m apart`);
  await page.slide("#time", 5);
  await page.settle();
  const early = await browser.run("return plslam.view.parts.others.runs[0].landmarks.points.geometry.drawRange.count");
  const n = await browser.run("return plslam.view.parts.others.runs[0].landmarks.pointData.seen.length");
  check.that(early < n, `the other map grows with time, too: ${early} of ${n} points`);
  await browser.run("plslam.replay.go(plslam.run.rows - 1)");
  await page.settle();
  await checkPick(page);
  await checkLinks();
});
