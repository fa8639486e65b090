// SPDX-License-Identifier: BSD-3-Clause
// node check_joint.mjs CHROMEDRIVER CHROMIUM PAGE.html: opens a report with the map of another run in it, and looks whether both are
// seen, one on the other, and can be switched. Exit code 1 where something is wrong.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);
await runChecks(check, browser, async (page) => {
  await page.open(pathToFileURL(resolve(file)).href);
  for (const layer of ["keyframes", "loopEdges"]) await page.switch(layer, false);
  const all = await page.look("#map", ["other0"]);
  check.that(all.near.other0 > 500, `the other run is seen: ${all.near.other0} pixels of its colour`);
  // The truth joins the two maps, so their paths lie on each other.
  for (const layer of ["points", "path", "truth"]) await page.switch(layer, false);
  await page.switch("segments", false);
  const paths = await page.look("#map", ["other0"]);
  check.that(paths.near.other0 > 150 && paths.near.other0 < all.near.other0,
    `landmarks and path: without landmarks ${paths.near.other0} pixels`);
  await page.switch("other0", false);
  const own = await page.look("#map", ["other0"]);
  check.that(own.near.other0 < 0.2 * paths.near.other0, `its switch hides it: ${own.near.other0} pixels left`);
  await page.switch("other0", true);
  const labels = await page.text("#layers");
  check.that(/Runs.*out.*out/s.test(labels), `both runs have a name: '${labels}'`);
  const apart = await browser.run(`
    const other = plslam.view.parts.others.runs[0], own = plslam.run;
    const p = [0, 0, 0];
    let largest = 0;
    for (let row = 0; row < own.rows; ++row) {
      own.position(row, p);
      const e = other.group.matrix.elements, q = other.path.slice(3 * row, 3 * row + 3);
      if (![...p, ...q].every(Number.isFinite)) continue;
      const moved = [0, 1, 2].map((k) => e[k] * q[0] + e[4 + k] * q[1] + e[8 + k] * q[2] + e[12 + k]);
      largest = Math.max(largest, Math.hypot(...moved.map((x, k) => x - p[k])));
    }
    return largest;`);
  check.that(apart < 0.2, `the paths are at most ${apart.toFixed(3)} m apart`);
  await page.slide("#time", 5);
  await page.settle();
  const early = await browser.run("return plslam.view.parts.others.runs[0].points.geometry.drawRange.count");
  const n = await browser.run("return plslam.view.parts.others.runs[0].pointData.seen.length");
  check.that(early < n, `the other map grows with time, too: ${early} of ${n} points`);
});
