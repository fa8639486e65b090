// SPDX-License-Identifier: BSD-3-Clause
// node check_link.mjs CHROMEDRIVER CHROMIUM REPORT.html: whether the address tells what is chosen, and shows the same when it is
// opened again. Exit code 1 where something is wrong.
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

async function checkChoices(page) {
  const point = await page.findPickable("points");
  await browser.press(point.at);
  await browser.until("return !document.getElementById('picked').hidden", "a box");
  const keyframe = await page.findPickable("keyframes");
  await browser.press(keyframe.at, keyframe.at, 1, kShift);
  await page.click("[data-mode=life]");
  await page.slide("#life", 3);
  await page.switch("odom", true);
  await page.switch("segments", false);
  await browser.key("d", "d");
  const address = await page.address();
  for (const [name, wanted] of [["colour", "life"], ["least", "3"], ["picture", "disparity"], ["layers", "-segments,odom"]]) {
    check.that(address[name] === wanted, `the address has ${name}=${wanted}: ${address[name]}`);
  }
  check.that(/^points:\d+$/.test(address.pick) && /^keyframes:\d+$/.test(address.to), "and what is chosen and measured");
}

const far = (a, b) => Math.max(...a.map((v, k) => Math.abs(v - b[k])));

/** The address, opened anew, shows the same. */
async function checkOpening(page) {
  await browser.run("plslam.replay.go(9)");
  await page.address();
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
  check.that((await page.address()).frame === `${before.frame}` && (await browser.run("return location.hash")) === hash, "and the address stays");
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
  await checkChoices(page);
  await checkOpening(page);
});
