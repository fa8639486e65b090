// SPDX-License-Identifier: BSD-3-Clause
// node check_link.mjs CHROMEDRIVER CHROMIUM REPORT.html: checks that the address contains the user's choices and shows
// the same view when it is opened again, and that a report requests nothing but itself. Exit code 1 on failure.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, kShift } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file] = process.argv.slice(2);
const url = pathToFileURL(resolve(file)).href;
const check = new Check();
const browser = await Browser.open(chromedriver, chromium, { network: true });

/** Checks that the frame in the address is that of the replay. */
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
  const box = await page.box("#map");
  const [x, y] = [box.x + 0.5 * box.width, box.y + 0.5 * box.height];
  // The view comes to rest in fewer pictures, which take long here.
  await browser.run("plslam.view.controls.dampingFactor = 0.5");
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

/** Returns the state of the page. */
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
  await browser.until("return !!document.querySelector('#picked .link')", "a box with frames");
  await page.click("#picked .link");
  await checkFrame(page, "a frame in the box");
  await browser.run("plslam.replay.go(plslam.run.rows - 1)");
  const keyframe = await page.findPickable("keyframes");
  await browser.press(keyframe.at, keyframe.at, 1, kShift);
  await page.click("[data-mode=life]");
  await page.slide("#life", 3);
  for (const layer of ["odom", "segments"]) await page.click(`[name=${layer}]`);
  await browser.key("d", "d");
  const address = await page.address();
  for (const [name, wanted] of [["colour", "life"], ["least", "3"], ["picture", "disparity"], ["layers", "-segments,odom"]]) {
    check.that(address[name] === wanted, `the address has ${name}=${wanted}: ${address[name]}`);
  }
  check.that(/^points:\d+$/.test(address.pick) && /^keyframes:\d+$/.test(address.to), "and what is chosen and measured");
}

const far = (a, b) => Math.max(...a.map((v, k) => Math.abs(v - b[k])));

/** Returns the state of the page after it has read another address. */
async function goTo(hash) {
  await browser.run(`return new Promise((read) => {
    addEventListener("hashchange", () => read(), { once: true });
    location.hash = arguments[0];
  })`, hash);
  return browser.run(kState);
}

/** Checks that the address, opened again, shows the same view. */
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
  const usual = await goTo("#view=top");
  const above = await browser.run("return plslam.view.fromAbove && plslam.view.pristine");
  check.that(above && usual.colour === "height" && usual.pick === null && usual.picture === "left" && usual.least === "0" && usual.frame === before.frame,
    `what it does not tell is as usual, and the frame stays: ${JSON.stringify(usual)}`);
}

async function checkNonsense() {
  const usual = await browser.run(kState);
  const most = await browser.run("return document.getElementById('life').max");
  for (const hash of ["#frame=x&eye=1,2&target=&pick=points:-&layers=,x&colour=y&least=z",
    "#frame=1e999&eye=1e200,0,0&target=0,0,0&colour=toString&picture=constructor&layers=toString&pick=constructor:1"]) {
    const now = await goTo(hash);
    // The controls compute the eye again from its direction: its last bit may change.
    check.that(now.frame === usual.frame && far(now.eye, usual.eye) < 1e-9 && now.colour === "height" && now.picture === "left",
      `nonsense changes nothing: ${hash}, ${JSON.stringify(now)}, before ${JSON.stringify(usual)}`);
  }
  await goTo("#least=1e9");
  check.that((await browser.run("return document.getElementById('life').max")) === most, "nor does it stretch the slider of lives");
  await browser.run("plslam.address.entries.unshift({ read: () => { throw new Error('not to be shown'); }, write: () => {} })");
  check.that((await goTo("#colour=seen")).colour === "seen", "a part that cannot be shown does not keep the others from it");
  await browser.run("plslam.address.entries.shift()");
}

/** Checks that the end of a measured distance may be in the next map of a continuing run. */
async function checkWaiting(page) {
  await browser.run("plslam.run.facts.finished = false");
  const { pick } = await goTo(`#pick=keyframes:${await browser.run("return plslam.run.map.keyframes.id[0]")}&to=keyframes:99999`);
  await browser.run("plslam.replay.go(3)");
  const address = await page.address();
  check.that(pick === address.pick && address.to === "keyframes:99999", `what is not in the map yet stays asked for: ${JSON.stringify(address)}`);
  await browser.run("plslam.run.facts.finished = true");
}

async function checkAlone(page) {
  await page.click("#help-button");
  await browser.run("for (const id of ['processes', 'plots', 'loops']) document.getElementById(id).scrollIntoView()");
  const asked = (await browser.requests()).filter((asked) => !asked.startsWith("data:") && asked !== "about:blank");
  check.that(asked.length > 0 && asked.every((address) => address.split("#")[0] === url), `it asks for nothing but itself: ${[...new Set(asked)]}`);
  const entries = await browser.run("return performance.getEntriesByType('resource').map((e) => e.name).filter((name) => !name.startsWith('data:'))");
  check.that(entries.length === 0, `nor does the page know of more: ${entries}`);
}

/** Checks that the page cannot make requests, and that a request would be detected. */
async function checkPolicy() {
  await browser.run("const image = new Image(); image.src = 'http://127.0.0.1:9/x.png'; return fetch('http://127.0.0.1:9/').catch(() => 0)");
  const said = (await browser.log()).map((entry) => entry.message);
  check.that(said.filter((message) => message.includes("Content Security Policy")).length >= 2, `its policy forbids more: ${said.join("; ")}`);
}

await runChecks(check, browser, async (page) => {
  // The first page is Chromium's own.
  await browser.go("about:blank");
  await browser.requests();
  await page.open(url);
  await checkTime(page);
  await checkDrag(page);
  await checkChoices(page);
  await checkOpening(page);
  await checkNonsense();
  await checkWaiting(page);
  await checkAlone(page);
  const errors = await page.errors();
  check.that(errors.length === 0, `no errors in the console before ${errors.join("; ")}`);
  await checkPolicy();
});
