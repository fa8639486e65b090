// SPDX-License-Identifier: BSD-3-Clause
// node check_use.mjs CHROMEDRIVER CHROMIUM REPORT.html: uses a report with mouse and keys, and checks the state of the
// page (no pictures, which take long here). Exit code 1 on failure.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, kShift } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);

async function checkFirstView() {
  const [path, points, filled] = await browser.run(`
    const { view, run } = plslam;
    const [width, height] = [view.canvas.clientWidth, view.canvas.clientHeight];
    const inside = (p) => {
      const at = view.picker.pixelOf(p);
      return !!at && at[0] >= 0 && at[1] >= 0 && at[0] <= width && at[1] <= height;
    };
    const share = (positions) => {
      let n = 0;
      for (let i = 0; i < positions.length; i += 3) n += inside(positions.subarray(i, i + 3));
      return (3 * n) / positions.length;
    };
    const back = view.world.quaternion.clone().invert();
    let most = 0;
    for (let i = 0; i < view.seen.length; i += 3) {
      const p = view.camera.position.clone().set(...view.seen.slice(i, i + 3)).applyQuaternion(back).toArray();
      const [x, y] = view.picker.pixelOf(p);
      most = Math.max(most, Math.abs((2 * x) / width - 1), Math.abs((2 * y) / height - 1));
    }
    return [share(run.path.p), share(run.map.points.p), most];`);
  check.that(path === 1, `the first view shows the whole path: ${path}`);
  check.that(points > 0.7, `and the middle of the landmarks: ${points}`);
  check.that(filled > 0.9 && filled < 1, `and fills the picture with them: up to ${filled} of its half`);
}

async function checkLevel(page) {
  const [up, from, n, range] = await browser.run(`
    const { view, run } = plslam;
    return [Array.from(view.inScene(run.map.vertical.up)), run.map.vertical.from, run.map.vertical.n, view.parts.landmarks.range];`);
  check.that(Math.abs(up[1] - 1) < 1e-6, `the vertical of the map stands upright: ${up}`);
  check.that(from === "lines" && n >= 8, `upright segments say so: ${from} ${n}`);
  check.that((await page.text("#notes")).includes(`${n} upright segments`), "and the page says that");
  check.that(/ m/.test(await page.text("#legend")), `heights from ${range} have their unit: '${await page.text("#legend")}'`);
}

async function checkPanel(page) {
  await browser.resize(1400, 900);
  await page.settle();
  await browser.run("window.scrollTo(0, 0)");
  const [bottom, hidden, scrolls] = await browser.run(`const side = document.getElementById("side");
    return [document.getElementById("replay").getBoundingClientRect().bottom, side.scrollHeight - side.clientHeight, getComputedStyle(side).overflowY];`);
  check.that(bottom <= 900, `map, panel and replay are whole in a window 900 high: ${bottom}`);
  check.that(hidden <= 1 || scrolls === "auto", `and so is the panel: ${hidden} pixels more, ${scrolls}`);
  const colours = await browser.run(`return [...document.querySelectorAll("#layers label:not([hidden]) .swatch")].map((s) => s.className + s.getAttribute("style"))`);
  check.that(new Set(colours).size >= colours.length - 1, `swatches are told apart: ${colours.length}`);
}

const scalesOf = `return Object.fromEntries(["tracked", "entropy"].map((key) => {
  const { x } = plslam.plots.plots.get(key).plot.scales;
  return [key, [x.min, x.max]];
}))`;

async function checkZoom(page) {
  await browser.run("document.getElementById('more-plots').open = true");
  await browser.run("document.getElementById('plots').scrollIntoView()");
  const box = "return document.querySelector('[data-plot=tracked] .u-over').getBoundingClientRect().toJSON()";
  // Plots are drawn when they become visible.
  await browser.until("return plslam.plots.plots.get('tracked').visible && plslam.plots.plots.get('entropy').visible", "plots in view");
  const { x, y, width, height } = await browser.run(box);
  const at = (share) => [x + share * width, y + 0.5 * height];
  const before = await browser.run(scalesOf);
  const row = await browser.run("return plslam.replay.row");
  await browser.press(at(0.3), at(0.6));
  await browser.until("return plslam.plots.zoomed !== null", "a zoom");
  const zoomed = await browser.run(scalesOf);
  const share = (zoomed.tracked[1] - zoomed.tracked[0]) / (before.tracked[1] - before.tracked[0]);
  check.that(Math.abs(share - 0.3) < 0.05, `dragging zooms: ${before.tracked} becomes ${zoomed.tracked}`);
  check.that(zoomed.entropy.every((v, i) => Math.abs(v - zoomed.tracked[i]) < 1e-6), `all figures follow: ${zoomed.entropy}`);
  check.that((await browser.run("return plslam.replay.row")) === row, "a drag is no click");
  check.that(!(await browser.run("return document.getElementById('zoom-out').hidden")), "there is a way back");
  await browser.press(at(0.5), at(0.5), 2);
  await browser.until("return plslam.plots.zoomed === null", "the whole run");
  check.that(JSON.stringify(await browser.run(scalesOf)) === JSON.stringify(before), "a double click shows the whole run");
  await browser.mouse("mouseMoved", at(0.25));
  await browser.until("return plslam.plots.plots.get('tracked').plot.cursor.left > 0", "a cursor");
  const [one, other] = await browser.run(`return ["tracked", "entropy"].map((key) => {
    const { plot } = plslam.plots.plots.get(key);
    return plot.posToVal(plot.cursor.left, "x");
  })`);
  check.that(Math.abs(one - other) < 0.02 * (before.tracked[1] - before.tracked[0]), `one cursor for all: ${one} and ${other}`);
  await browser.press(at(0.25));
  const [there, wanted] = await browser.run("return [plslam.replay.row, plslam.run.rowAt(arguments[0])]", one);
  check.that(Math.abs(there - wanted) <= 1, `a click moves the replay there: row ${there}, ${one} s is in row ${wanted}`);
  await browser.mouse("mouseMoved", [1, 1]);
  await browser.run("plslam.replay.go(plslam.run.rows - 1)");
  await page.settle();
}

async function checkStrength(page) {
  const [low, high] = await browser.run("const { shared } = plslam.run.map.edges; return [shared.at(-1), shared[0]]");
  const edges = "return plslam.view.parts.keyframes.objects.covisibility.geometry.attributes.position.count / 2";
  const all = await browser.run(edges);
  const least = Math.round(0.5 * (low + high));
  await page.slide("#strength", least);
  const wanted = await browser.run("return plslam.run.map.edges.shared.filter((s) => s >= arguments[0]).length", least);
  const shown = await browser.run(edges);
  check.that(shown === wanted && shown < all, `from ${least} shared landmarks on: ${shown} of ${all} edges`);
  check.that(await browser.run("return plslam.view.parts.keyframes.objects.covisibility.visible"), "which are shown then");
  await page.slide("#strength", low);
  await page.switch("covisibility", false);
}

/** Clicks on the first visible object of a table; returns its row. */
async function clickOn(page, type) {
  const { row, at } = await page.findPickable(type);
  check.that(row >= 0, `one of ${type} can be clicked`);
  await browser.mouse("mouseMoved", [at[0] - 1, at[1]]);
  await browser.until("return document.getElementById('map').style.cursor === 'pointer'", "a pointer over it");
  await browser.press(at);
  await browser.until("return !document.getElementById('picked').hidden", "a box");
  return row;
}

async function checkMeasuring(page, point) {
  const other = await page.findPickable("keyframes");
  await browser.press(other.at, other.at, 1, kShift);
  await browser.until("return !document.getElementById('measured').hidden", "a label");
  const wanted = await browser.run(`
    const { run } = plslam;
    const [a, b] = [run.map.points.p.subarray(3 * arguments[0]), run.map.keyframes.p.subarray(3 * arguments[1])];
    return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);`, point, other.row);
  const measured = await page.text("#picked");
  const id = await browser.run("return plslam.run.map.keyframes.id[arguments[0]]", other.row);
  check.that(measured.includes("distance") && measured.includes(`to keyframe ${id}`), `with the shift key the distance (${wanted.toFixed(2)} m): '${measured}'`);
  check.that(await browser.run("return plslam.view.parts.selection.measure.object.visible"), "and a line");
  const label = await page.text("#measured");
  check.that(Math.abs(parseFloat(label) * (label.includes("cm") ? 0.01 : 1) - wanted) < 0.01 * wanted + 0.005, `with its length: '${label}'`);
  const off = await browser.run(`
    const { view, run } = plslam;
    const { picked, other } = view.parts.selection;
    const ends = [picked, other].map((p) => view.picker.pixelOf(view.parts.selection.placeOf(run, p)));
    const [map, label] = ["map", "measured"].map((id) => document.getElementById(id).getBoundingClientRect());
    const at = [label.x + 0.0 - map.x, label.y + 0.5 * label.height - map.y];
    const [[ax, ay], [bx, by]] = ends;
    const t = Math.min(1, Math.max(0, ((at[0] - ax) * (bx - ax) + (at[1] - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)));
    return Math.hypot(at[0] - ax - t * (bx - ax), at[1] - ay - t * (by - ay));`);
  check.that(off < 20, `beside the line: ${off.toFixed(1)} pixels`);
  const shown = await browser.run(`
    const { view, run } = plslam;
    const { selection } = view.parts;
    selection.measureTo(run, { ...selection.picked });
    return selection.measure.object.visible;`);
  check.that(!shown, "nothing has a distance from itself");
}

/** Checks that a double click makes the clicked object the centre of rotation. */
async function checkFocus(page) {
  const { at } = await page.findPickable("points");
  await browser.press(at, at, 2);
  await page.settle();
  const off = await browser.run(`
    const { view, run } = plslam;
    const { selection } = view.parts;
    const p = view.inScene(selection.placeOf(run, selection.picked));
    const t = view.controls.target;
    return Math.hypot(t.x - p[0], t.y - p[1], t.z - p[2]);`);
  check.that(off < 1e-4, `a double click turns the view around what was clicked: ${off} m off`);
  await browser.key("Escape");
  await browser.key("1", "1");
  await page.settle();
}

async function checkPick(page) {
  const rays = "return plslam.view.parts.selection.rays.n";
  const point = await clickOn(page, "points");
  const observations = await browser.run("return plslam.run.map.points.observations[arguments[0]]", point);
  const id = await browser.run("return plslam.run.observersOf('points').ids[arguments[0]]", point);
  check.that((await browser.run(rays)) === observations, `a ray to each of the ${observations} keyframes that observe it`);
  const text = await page.text("#picked");
  check.that(text.includes(`Point ${id}`) && text.includes(`${observations} keyframe`) && /sigma[<.\d ]+ ?[ckm]?m/.test(text), `its box: '${text}'`);
  const life = await browser.run("return plslam.run.map.points.life[arguments[0]]", point);
  check.that(text.includes(`seen over${life} frame`), `and that it was seen over ${life} frames`);
  check.that(await browser.run("return plslam.view.parts.selection.frusta.visible"), "whose keyframes are marked");
  await checkMeasuring(page, point);
  await browser.key("Escape");
  await browser.until("return document.getElementById('picked').hidden", "no box");
  const keyframe = await clickOn(page, "keyframes");
  const seen = await browser.run(`let n = 0;
    for (const type of ["points", "segments"]) n += plslam.run.observersOf(type).rows.filter((row) => row === arguments[0]).length;
    return n;`, keyframe);
  check.that((await browser.run(rays)) === seen && seen > 10, `a keyframe has rays to its ${seen} landmarks`);
  await browser.key("Escape");
  await checkLongRun(page, point, id, rays);
}

/** Checks a long run, for which only ids are stored: the page states it, and the selection stays in the next map of a live page. */
async function checkLongRun(page, point, id, rays) {
  await browser.run(`const { run, view } = plslam;
    const packed = (ids) => {
      let bytes = "";
      ids.forEach((id, i) => {
        let number = id - (i ? ids[i - 1] : -1);
        for (; number >= 128; number = Math.floor(number / 128)) bytes += String.fromCharCode(128 + (number % 128));
        bytes += String.fromCharCode(number, 0);
      });
      return btoa(bytes);
    };
    const [points, segments] = ["points", "segments"].map((type) => packed(run.observersOf(type).ids));
    [run.packedObservers, run.observersKnown, run.observers] = [{ points, segments }, false, {}];
    view.parts.selection.choose(run, { type: "points", row: arguments[0] });
    run.map = { ...run.map };
    view.parts.selection.setRun(run, view.size);`, point);
  const text = await page.text("#picked");
  check.that(text.includes("not stored") && text.includes(`Point ${id}`) && (await browser.run(rays)) === 0, `what a long run leaves out is said: '${text}'`);
  await page.click("#picked .close");
  check.that(await browser.run("return document.getElementById('picked').hidden"), "a button closes the box");
}

/** Checks that a slider hides landmarks seen over few frames, and that colours show them. */
async function checkLife(page) {
  const drawn = "const { pointData, segmentData } = plslam.view.parts.landmarks; return [pointData.seen.length, segmentData.seen.length]";
  const lives = await browser.run("return ['points', 'segments'].map((type) => Array.from(plslam.run.map[type].life))");
  const least = Math.round(lives[0].toSorted((a, b) => a - b)[Math.floor(0.7 * lives[0].length)]);
  await browser.run("document.getElementById('life').focus()");
  await page.slide("#life", least);
  const wanted = lives.map((l) => l.filter((frames) => frames >= least).length);
  const shown = await browser.run(drawn);
  check.that(`${shown}` === `${wanted}` && shown[0] < lives[0].length && shown[0] > 0, `from ${least} frames on ${shown} of ${lives.map((l) => l.length)} landmarks`);
  const observed = await browser.run(`
    const { run } = plslam;
    const { rows, starts } = run.observersOf("points");
    return run.map.points.life.every((life, i) => life === run.map.keyframes.frame[rows[starts[i + 1] - 1]] - run.map.keyframes.frame[rows[starts[i]]]);`);
  check.that(observed, "which is from the first keyframe that observes them to the last");
  await page.slide("#life", 0);
  check.that(`${await browser.run(drawn)}` === `${lives.map((l) => l.length)}`, "and all again");
  await page.settle();
  const before = await page.look("#map");
  await page.click("[data-mode=life]");
  await page.settle();
  check.that((await page.look("#map")).digest !== before.digest && /seen over/.test(await page.text("#legend")), "colours tell it, too");
  await page.click("[data-mode=height]");
}

async function checkHelp(page) {
  const open = "return document.getElementById('help').open";
  await browser.key("?", "?");
  check.that(await browser.run(open), "the key ? opens the help");
  const text = await browser.run("return document.getElementById('help').innerText");
  for (const what of ["Shift and click", "R", "D", "Space", "1, 2, 3", "double click"]) check.that(text.includes(what), `which tells of '${what}'`);
  const state = "return [plslam.view.fromAbove, plslam.replay.row, plslam.replay.playing, plslam.picture.isLarge, plslam.picture.wanted].join()";
  const before = await browser.run(state);
  await browser.run("document.activeElement.blur()");
  for (const key of ["2", "f", "d", " "]) await browser.key(key, key);
  await browser.key("ArrowLeft");
  check.that((await browser.run(state)) === before, `while it is open, keys do nothing to the page behind it: ${before}`);
  await browser.key("Escape");
  check.that(!(await browser.run(open)), "Escape closes it");
  await page.click("#help-button");
  check.that(await browser.run(open), "a button, too");
  await browser.key("?", "?");
  check.that(!(await browser.run(open)), "and the key closes it");
}

async function checkLarge(page) {
  const width = async () => (await page.box("#frame")).width;
  const small = await width();
  await browser.key("f", "f");
  await page.settle();
  const large = await width();
  check.that(large > 1.8 * small, `the key F makes the picture large: ${small} pixels wide, then ${large}`);
  await browser.key("Escape");
  check.that((await width()) === small, "Escape makes it small again");
  await browser.key("f", "f", 0, 1);
  check.that((await width()) > 1.8 * small, "a key that is held down does so once");
  await browser.key("Escape");
  await page.settle();
  const { x, y } = await page.box("#frame");
  await browser.press([x + 20, y + 20]);
  check.that((await width()) > 1.8 * small, "a click, too");
  await browser.press([400, 300]);
  check.that((await width()) === small, "and another one");
}

async function checkKeys() {
  await browser.run("plslam.replay.go(0); document.getElementById('speed').value = '0.5'; document.activeElement.blur()");
  await browser.key(" ", " ");
  check.that(await browser.run("return plslam.replay.playing"), "space plays");
  await browser.key(" ", " ");
  check.that(!(await browser.run("return plslam.replay.playing")), "and pauses");
  await browser.run("plslam.replay.go(5)");
  await browser.key("ArrowRight");
  await browser.key("ArrowRight");
  await browser.key("ArrowLeft");
  check.that((await browser.run("return plslam.replay.row")) === 6, "arrows step by a frame");
  const views = "return [!!plslam.view.fromAbove, plslam.view.flying]";
  for (const [key, wanted] of [["2", [true, false]], ["3", [true, true]], ["1", [false, false]]]) {
    await browser.key(key, key);
    check.that(JSON.stringify(await browser.run(views)) === JSON.stringify(wanted), `key ${key}: ${await browser.run(views)} (from above, flying)`);
    if (key !== "2") check.that(await browser.run("return plslam.replay.playing"), `key ${key}: the replay plays`);
  }
  await browser.run("plslam.replay.pause()");
}

await runChecks(check, browser, async (page) => {
  await page.open(pathToFileURL(resolve(file)).href);
  await checkFirstView();
  await checkLevel(page);
  await checkPanel(page);
  await checkStrength(page);
  await checkLife(page);
  await checkFocus(page);
  await checkPick(page);
  await checkZoom(page);
  await checkHelp(page);
  await checkLarge(page);
  await checkKeys();
});
