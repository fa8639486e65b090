// SPDX-License-Identifier: BSD-3-Clause
// node check_surfaces.mjs CHROMEDRIVER CHROMIUM REPORT.html: checks that the report of a run with --dense shows surfaces and
// grid, and that their switches hide them. Exit code 1 on failure.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);

await runChecks(check, browser, async (page) => {
  await page.open(pathToFileURL(resolve(file)).href);
  await browser.until("return plslam.view.parts.floor.plane.visible", "the picture of the grid");
  await page.click("#view-top");
  await page.settle();
  const [points, inWalls] = await browser.run(`
    const { points, low_w, step_m } = plslam.run.surfaces;
    const path = plslam.run.path.p;
    let near = 0;
    for (let i = 0; i < points.p.length; i += 3) {
      const at = [0, 1, 2].map((k) => low_w[k] + step_m * points.p[i + k] - path[k]);
      near += Math.hypot(...at) < 12 ? 1 : 0;
    }
    return [points.grey.length, near / points.grey.length];`);
  check.that(points > 3000 && inWalls > 0.95, `${points} points, ${(100 * inWalls).toFixed(1)} % of them around the first camera`);
  // The path lies in free space: the picture below each of its positions is white.
  const [known, free] = await browser.run(`
    const { plane, image } = plslam.view.parts.floor;
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { path } = plslam.run;
    let [known, free] = [0, 0];
    for (let i = 0; i < path.p.length; i += 3) {
      const at = plane.worldToLocal(plslam.view.own.localToWorld(plane.position.clone().set(path.p[i], path.p[i + 1], path.p[i + 2])));
      const grey = context.getImageData(Math.floor((at.x + 0.5) * image.width), Math.floor((0.5 - at.y) * image.height), 1, 1).data[0];
      known += 1;
      free += grey > 230 ? 1 : 0;
    }
    return [known, free];`);
  check.that(known > 50 && free > 0.95 * known, `${free} of ${known} positions of the camera are above free cells`);
  for (const layer of ["points", "segments", "keyframes", "loopEdges", "path", "truth"]) await page.switch(layer, false);
  const both = await page.look("#map", ["free"]);
  await page.switch("floor", false);
  const surfaces = await page.look("#map", ["free"]);
  await page.switch("surface", false);
  const none = await page.look("#map");
  check.that(surfaces.drawn > 20000, `surfaces: ${surfaces.drawn} pixels drawn`);
  check.that(both.digest !== surfaces.digest, "the grid is a layer of its own");
  check.that(none.drawn < 0.3 * surfaces.drawn, `without both: ${none.drawn} pixels drawn`);
  await page.switch("floor", true);
  const grid = await page.look("#map");
  check.that(grid.drawn > none.drawn + 1000, `grid alone: ${grid.drawn} pixels drawn`);
});
