// SPDX-License-Identifier: BSD-3-Clause
// node check_address.mjs CHROMEDRIVER CHROMIUM REPORT.html: whether the address follows what hands do. Exit code 1 where something
// is wrong.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, kShift } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file] = process.argv.slice(2);
const url = pathToFileURL(resolve(file)).href;
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);

/** The frame in the address is that of the replay. */
async function checkFrame(page, what) {
  const frame = await browser.run("return plslam.run.frames.id[plslam.replay.row]");
  const written = (await page.address()).frame;
  check.that(written === `${frame}`, `${what} writes the frame ${frame}: ${written}`);
  return frame;
}

async function checkTime(page) {
  await browser.run("plslam.replay.go(5); document.activeElement.blur()");
  await browser.key("ArrowRight");
  await browser.key("ArrowRight", undefined, kShift);
  check.that((await checkFrame(page, "an arrow")) === (await browser.run("return plslam.run.frames.id[16]")), "after 16 frames");
  await browser.run("document.getElementById('plots').scrollIntoView()");
  await browser.until("return plslam.plots.plots.get('tracked').visible", "a figure");
  const { x, y, width, height } = await page.box("[data-plot=tracked] .u-over");
  await browser.press([x + 0.4 * width, y + 0.5 * height]);
  check.that((await checkFrame(page, "a click in a figure")) !== 16, "which is another");
  if (await browser.run("return plslam.run.loops.length > 0")) {
    await browser.run("document.querySelector('#loop-table tbody tr').scrollIntoView({ block: 'center' })");
    const row = await page.box("#loop-table tbody tr td[data-name=frames]");
    await browser.press([row.x + 5, row.y + 5]);
    await checkFrame(page, "a row of loops");
    await page.slide("#blend", 1);
  }
  await page.settle();
}

async function checkDrag(page) {
  await page.settle();
  const box = await page.box("#map");
  const [x, y] = [box.x + 0.5 * box.width, box.y + 0.5 * box.height];
  await browser.mouse("mouseMoved", [x, y]);
  await browser.mouse("mousePressed", [x, y], 1);
  for (let i = 1; i <= 6; ++i) {
    await browser.devtools("Input.dispatchMouseEvent", { type: "mouseMoved", x: x + 15 * i, y: y + 5 * i, button: "left", buttons: 1 });
  }
  await browser.mouse("mouseReleased", [x + 90, y + 30], 1);
  const eye = (await page.address()).eye?.split(",").map(Number);
  const now = await browser.run("return plslam.view.camera.position.toArray()");
  const off = Math.max(...now.map((v, k) => Math.abs(v - (eye?.[k] ?? NaN))));
  check.that(off < 5e-4 * Math.hypot(...now), `a drag writes where the eye comes to rest: ${eye}, ${off} m off`);
}

/** As does a frame that is named in the box of what was clicked. */
async function checkBox(page) {
  const point = await page.findPickable("points");
  await browser.press(point.at);
  await browser.until("return !!document.querySelector('#picked .link')", "a box with frames");
  await browser.run("document.querySelector('#picked .link').click()");
  await checkFrame(page, "a frame in the box");
}

await runChecks(check, browser, async (page) => {
  await page.open(url);
  await checkTime(page);
  await checkDrag(page);
  await checkBox(page);
});
