// SPDX-License-Identifier: BSD-3-Clause
// node check_report.mjs CHROMEDRIVER CHROMIUM REPORT.html [all|fluid] [SCREENSHOT.png]: opens a report from the file system in
// headless Chromium, uses its controls, and checks the screen; "fluid": only checks that the map is drawn, and how
// fast. Exit code 1 on failure.
import { writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file, what = "all", picture] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);

async function checkMap(page, withSwitches) {
  const all = await page.look("#map", ["path", "truth"]);
  check.that(all.drawn > 2000 && all.colours > 100, `the map is not blank: ${all.drawn} pixels drawn, ${all.colours} colours`);
  check.that(all.near.path > 150, `the estimated path is seen: ${all.near.path} pixels of its colour`);
  if (!withSwitches) return;
  await page.switch("path", false);
  const without = await page.look("#map", ["path"]);
  check.that(without.near.path < 0.35 * all.near.path, `its switch hides it: ${without.near.path} pixels left`);
  await page.switch("points", false);
  await page.switch("segments", false);
  const bare = await page.look("#map");
  check.that(bare.drawn < 0.5 * without.drawn, `switches hide the landmarks: ${without.drawn} pixels drawn, then ${bare.drawn}`);
  await page.click("[name=points]");
  await page.click("[name=segments]");
  await page.switch("path", true);
  const again = await page.look("#map", ["path"]);
  check.that(again.near.path > 0.8 * all.near.path, `and show all again: ${again.near.path} pixels of the path`);
}

async function checkColours(page) {
  const before = await page.text("#legend");
  await page.click("[data-mode=seen]");
  check.that((await page.text("#legend")) !== before, "points are coloured by age when asked");
  await page.click("[data-mode=height]");
  const light = await browser.run("return getComputedStyle(document.documentElement).backgroundColor");
  await page.click("#theme");
  const dark = await browser.run("return getComputedStyle(document.documentElement).backgroundColor");
  check.that(light !== dark, `light and dark: ${light}, ${dark}`);
  await page.click("#theme");
}

async function checkReplay(page) {
  const rows = await browser.run("return plslam.run.rows");
  const shown = "return plslam.view.parts.landmarks.points.geometry.drawRange.count";
  const atEnd = await browser.run(shown);
  await page.slide("#time", Math.floor(rows / 4));
  await page.settle();
  const early = await browser.run(shown);
  const caption = await page.text("#frame-caption");
  const id = await browser.run("return plslam.run.frames.id[arguments[0]]", Math.floor(rows / 4));
  check.that(caption.startsWith(`frame ${id} `), `the slider moves the run: '${caption}'`);
  check.that(early < atEnd, `the map grows with time: ${early} of ${atEnd} points at a quarter`);
  await browser.run("document.getElementById('speed').value = '20'");
  await page.click("#play");
  await browser.until("return plslam.replay.row > arguments[0]".replace("arguments[0]", `${Math.floor(rows / 4)}`), "a replay that goes on");
  await page.click("#fly");
  await browser.until("return !plslam.replay.playing", "the end of the replay", 20);
  check.that((await browser.run("return plslam.replay.row")) === rows - 1, "the replay comes to its end");
  await page.click("#fly");
  await page.click("#view-all");
}

async function checkProcesses(page) {
  const states = await browser.run("return [...document.querySelectorAll('#process-table [data-name=state]')].map((td) => td.textContent)");
  check.that(states.length >= 4 && states.every((state) => state === "ended"), `processes of a run that is over have ended: ${states}`);
}

async function checkLoops(page) {
  const [loops, corrections] = await browser.run("return [plslam.run.loops.length, plslam.run.corrections.length]");
  const rows = await browser.run("return document.querySelectorAll('#loop-table tbody tr').length");
  check.that(rows === loops, `${loops} loops in ${rows} rows`);
  if (!corrections) return;
  const after = await page.look("#map", ["before"]);
  await page.slide("#blend", 0);
  await page.settle();
  const before = await page.look("#map", ["before"]);
  check.that(before.near.before > after.near.before + 40,
    `before the correction is seen: ${before.near.before} pixels, after ${after.near.before}`);
  await page.slide("#blend", 1);
  await page.click("#loop-table tbody tr");
  check.that(await browser.run("return !!document.querySelector('#loop-table tr.chosen')"), "a loop can be chosen");
  await page.slide("#blend", 1);
}

async function checkPlots() {
  const folded = await browser.run(`return [...document.querySelectorAll("#more-plots .plot")].map((plot) => [plot.dataset.plot, plot.checkVisibility()])`);
  check.that(folded.length > 0 && folded.every(([name, visible]) => !visible && !/error|rotation|tracked/.test(name)),
    `plots for developers are folded: ${JSON.stringify(folded)}`);
  await browser.run("document.getElementById('more-plots').open = true");
  await browser.until("return [...document.querySelectorAll('#more-plots .plot')].every((plot) => plot.checkVisibility())", "unfolded plots");
  const plots = await browser.run(`return [...document.querySelectorAll(".plot")].map((plot) => {
    const canvas = plot.querySelector("canvas");
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let drawn = 0;
    for (let i = 3; i < pixels.length; i += 4) drawn += pixels[i] > 0;
    return [plot.dataset.plot, drawn];
  })`);
  console.log(`     plots: ${plots.map(([name, drawn]) => `${name} (${drawn} pixels)`).join(", ")}`);
  for (const wanted of ["tracked", "stages", "queues", "repairs"]) {
    check.that(plots.some(([name, drawn]) => name === wanted && drawn > 1000), `there is a plot '${wanted}'`);
  }
}

async function checkNarrow(page) {
  for (const width of [1100, 700, 390]) {
    await browser.resize(width, 800);
    await page.settle();
    const wide = await browser.run("return document.documentElement.scrollWidth");
    check.that(wide <= width, `at ${width} pixels nothing sticks out: ${wide}`);
  }
  await browser.resize(1100, 800);
  await page.settle();
}

/** Measures the time of a picture in the page itself, and with all its pixels, drawn here without a graphics card. */
async function checkFrameTimes() {
  const [points, segments, own_ms, all_ms] = await browser.run(`
    const { view, run } = plslam;
    const gl = view.renderer.getContext();
    const own = [], all = [];
    for (let i = 0; i < 9; ++i) {
      view.camera.position.x += view.size / 500;
      const start = performance.now();
      view.render();
      own.push(performance.now() - start);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      all.push(performance.now() - start);
    }
    const median = (times) => times.sort((a, b) => a - b)[4];
    return [run.map.points.seen.length, run.map.segments.seen.length, median(own), median(all)];`);
  console.log(`     ${points} points, ${segments} segments: ${own_ms.toFixed(1)} ms a picture, ${all_ms.toFixed(1)} ms with all pixels drawn by the processor`);
  check.that(own_ms < 16, "the page is ready for 60 pictures a second");
  check.that(all_ms < 2000, "and can be used even without a graphics card");
}

await runChecks(check, browser, async (page) => {
  const start = Date.now();
  await page.open(pathToFileURL(resolve(file)).href);
  console.log(`     open after ${Date.now() - start} ms`);
  if (picture) writeFileSync(picture, await browser.screenshot());
  check.that((await page.text("#dataset")).length > 0, `the run has a name: '${await page.text("#dataset")}'`);
  const [tracked, warnings, hidden] = await browser.run(`const box = document.getElementById("warnings");
    return [plslam.run.facts.tracked_percent, plslam.run.facts.warnings.length, box.hidden];`);
  const summary = await page.text("#summary");
  check.that(summary.includes(`${tracked === 100 ? "100" : tracked.toFixed(1)} %`), `${tracked} % tracked are told as such`);
  check.that(hidden === (warnings === 0), `${warnings} warnings, and a box only where there are some`);
  await checkMap(page, what === "all");
  if (what === "all") {
    await checkColours(page);
    await checkReplay(page);
    await checkProcesses(page);
    await checkLoops(page);
    await checkPlots();
    await checkNarrow(page);
  }
  await checkFrameTimes();
});
