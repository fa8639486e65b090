// SPDX-License-Identifier: BSD-3-Clause
// node check_live.mjs CHROMEDRIVER CHROMIUM URL: opens the live page of a run that goes on, and watches it grow. Exit code 1
// where something is wrong.
import { Browser } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, url] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);
await runChecks(check, browser, async (page) => {
  await page.open(url);
  const first = await browser.run("return plslam.run.rows");
  check.that((await page.text("#kicker")).includes("live"), `it says that it is live: '${await page.text("#kicker")}'`);
  await browser.until(`return plslam.run.rows > ${first} + 5`, "more frames");
  await browser.until("return plslam.run.map && plslam.run.map.points.seen.length > 50", "a map");
  await browser.until("return plslam.run.pictures.length > 0", "a picture");
  const rows = await browser.run("return plslam.run.rows");
  check.that(rows > first, `frames come: ${first}, then ${rows}`);
  await page.settle();
  const seen = await page.look("#map", ["path"]);
  check.that(seen.drawn > 500 && seen.near.path > 30, `and are drawn: ${seen.drawn} pixels, ${seen.near.path} of the path`);
  const processes = await browser.run(`return Object.fromEntries([...document.querySelectorAll("#process-list li")].map((li) => [li.dataset.process, li.textContent]))`);
  for (const name of ["player", "vo", "mapping", "loop", "viewer"]) {
    check.that(/running|ready|finished/.test(processes[name]) && /restart/.test(processes[name]), `the state of ${name}: '${processes[name]}'`);
  }
  check.that(/ms a frame/.test(processes.vo), "and what a frame takes");
  const ids = await browser.run("return Array.from(plslam.run.frames.id)");
  check.that(ids.every((id, i) => i === 0 || id > ids[i - 1]), "each frame once, in order");
  const columns = await browser.run("return Object.entries(plslam.run.frames).map(([name, c]) => [name, c.length / plslam.run.frameWidths[name]])");
  check.that(columns.every(([, n]) => n === columns[0][1]), `columns are equally long: ${columns}`);
});
