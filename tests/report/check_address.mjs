// SPDX-License-Identifier: BSD-3-Clause
// node check_address.mjs CHROMEDRIVER CHROMIUM REPORT.html: whether the address follows what hands do, and leads there again. Exit
// code 1 where something is wrong.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, kShift } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file] = process.argv.slice(2);
const url = pathToFileURL(resolve(file)).href;
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);

/** What the page shows, as it says itself. */
const kState = `
  const { replay, view, picture } = plslam;
  const { selection } = view.parts;
  return {
    frame: replay.run.frames.id[replay.row], eye: view.camera.position.toArray(), target: view.controls.target.toArray(),
    colour: view.colourMode, least: document.getElementById("life").value, picture: picture.wanted,
    layers: [...view.layers].filter(([, on]) => on).map(([name]) => name).join(),
    pick: selection.textOf(selection.picked, selection.id), to: selection.textOf(selection.other, selection.otherId),
    pressed: document.querySelector("[data-mode][aria-pressed=true]").dataset.mode,
  };`;

/** The frame in the address is that of the replay. */
async function checkFrame(page, what) {
  const frame = await browser.run("return plslam.run.frames.id[plslam.replay.row]");
  const written = await page.inAddress("frame");
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
  const eye = (await page.inAddress("eye"))?.split(",").map(Number);
  const now = await browser.run("return plslam.view.camera.position.toArray()");
  const off = Math.max(...now.map((v, k) => Math.abs(v - (eye?.[k] ?? NaN))));
  check.that(off < 1e-4 * Math.hypot(...now), `a drag writes where the eye comes to rest: ${eye}, ${off} m off`);
}

async function checkChoices(page) {
  const point = await page.findPickable("points");
  await browser.press(point.at);
  const link = await browser.run("document.querySelector('#picked .link').click(); return plslam.replay.row");
  check.that((await checkFrame(page, "a frame in the box")) >= 0 && link >= 0, "of what was clicked");
  await browser.run("plslam.replay.go(plslam.run.rows - 1)");
  const keyframe = await page.findPickable("keyframes");
  await browser.press(keyframe.at, keyframe.at, 1, kShift);
  await page.click("[data-mode=life]");
  await page.slide("#life", 3);
  await page.switch("odom", true);
  await page.switch("segments", false);
  await browser.key("d", "d");
  for (const [name, wanted] of [["colour", "life"], ["least", "3"], ["picture", "disparity"], ["layers", "-segments,odom"]]) {
    check.that((await page.inAddress(name)) === wanted, `the address has ${name}=${wanted}: ${await page.inAddress(name)}`);
  }
  check.that(/^points:\d+$/.test(await page.inAddress("pick")) && /^keyframes:\d+$/.test(await page.inAddress("to")), "and what is chosen and measured");
}

const far = (a, b) => Math.max(...a.map((v, k) => Math.abs(v - b[k])));

/** The address, opened anew, shows the same. */
async function checkOpening(page) {
  await browser.run("plslam.replay.go(9)");
  await page.inAddress("frame");
  const [hash, before] = [await browser.run("return location.hash"), await browser.run(kState)];
  await page.open(url + hash);
  const after = await browser.run(kState);
  console.log(`     ${hash}`);
  for (const name of ["frame", "colour", "pressed", "least", "picture", "layers", "pick", "to"]) {
    check.that(before[name] !== null && `${before[name]}` === `${after[name]}`, `opened anew, ${name} is ${before[name]}: ${after[name]}`);
  }
  const off = Math.max(far(before.eye, after.eye), far(before.target, after.target));
  check.that(off < 1e-4 * Math.hypot(...before.eye), `and the eye is where it was: ${off} m off`);
  check.that((await page.text("#measured")).includes("m"), `with the length: '${await page.text("#measured")}'`);
  check.that((await page.inAddress("frame")) === `${before.frame}` && (await browser.run("return location.hash")) === hash, "and the address stays");
  await browser.run("location.hash = '#view=top'");
  await browser.until("return plslam.view.fromAbove && plslam.view.pristine", "another address that is typed in");
  const usual = await browser.run(kState);
  check.that(usual.colour === "height" && usual.pick === null && usual.picture === "left" && usual.least === "0" && usual.frame === before.frame,
    `what it does not tell is as usual, and the frame stays: ${JSON.stringify(usual)}`);
  await browser.run("location.hash = '#frame=x&eye=1,2&target=&pick=points:-&layers=,x&colour=y&least=z'");
  await page.settle();
  const nonsense = await browser.run(kState);
  check.that(nonsense.frame === usual.frame && far(nonsense.eye, usual.eye) === 0 && nonsense.colour === "height", "nonsense in the address changes nothing");
}

await runChecks(check, browser, async (page) => {
  await page.open(url);
  await checkTime(page);
  await checkDrag(page);
  await checkChoices(page);
  await checkOpening(page);
});
