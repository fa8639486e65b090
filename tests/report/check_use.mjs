// SPDX-License-Identifier: BSD-3-Clause
// node check_use.mjs CHROMEDRIVER CHROMIUM REPORT.html: uses a report as hands do, with mouse and keys, and looks at what the page
// then knows (no pictures, which take long here). Exit code 1 where something is wrong.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
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
  const [up, lines, range] = await browser.run(`
    const { view, run } = plslam;
    return [Array.from(view.inScene(run.map.vertical.up)), run.map.vertical.lines, view.parts.landmarks.range];`);
  check.that(Math.abs(up[1] - 1) < 1e-6, `the vertical of the map stands upright: ${up}`);
  check.that(lines >= 8, `upright segments say so: ${lines}`);
  check.that((await page.text("#notes")).includes(`${lines} upright segments`), "and the page says that");
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
  await browser.run("document.getElementById('plots').scrollIntoView()");
  const box = "return document.querySelector('[data-plot=tracked] .u-over').getBoundingClientRect().toJSON()";
  // Plots that come into view are drawn then.
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

/** Clicks on the first of a table that nothing else hides; its row. */
async function clickOn(page, type) {
  const [row, x, y] = await browser.run(`
    const { view, run } = plslam;
    const box = view.canvas.getBoundingClientRect();
    const { p } = run.map[arguments[0]];
    for (let row = 0; row < p.length / 3; ++row) {
      const at = view.picker.pixelOf(p.subarray(3 * row, 3 * row + 3));
      const [x, y] = at ? [Math.round(at[0]), Math.round(at[1])] : [-1, -1];
      if (document.elementFromPoint(box.x + x, box.y + y) !== view.canvas) continue;
      const picked = view.picker.pick(x, y);
      if (picked?.type === arguments[0] && picked.row === row) return [row, box.x + x, box.y + y];
    }
    return [-1, 0, 0];`, type);
  check.that(row >= 0, `one of ${type} can be clicked`);
  await browser.press([x, y]);
  await browser.until("return !document.getElementById('picked').hidden", "a box");
  return row;
}

async function checkPick(page) {
  const rays = "return plslam.view.parts.selection.rays.n";
  const point = await clickOn(page, "points");
  const observations = await browser.run("return plslam.run.map.points.observations[arguments[0]]", point);
  const id = await browser.run("return plslam.run.observersOf('points').ids[arguments[0]]", point);
  check.that((await browser.run(rays)) === observations, `a ray to each of the ${observations} keyframes that observe it`);
  const text = await page.text("#picked");
  check.that(text.includes(`Point ${id}`) && text.includes(`${observations} keyframes`) && /sigma[<.\d ]+ ?[ckm]?m/.test(text), `its box: '${text}'`);
  check.that(await browser.run("return plslam.view.parts.selection.frusta.visible"), "whose keyframes are marked");
  const wanted = await browser.run(`
    const { run, view } = plslam;
    const [a, b] = [run.map.points.p.subarray(3 * arguments[0]), run.map.keyframes.p];
    view.parts.selection.measureTo(run, { type: "keyframes", row: 0 });
    return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);`, point);
  const measured = await page.text("#picked");
  check.that(measured.includes("distance") && measured.includes("to keyframe 0"), `with the shift key the distance (${wanted.toFixed(2)} m): '${measured}'`);
  check.that(await browser.run("return plslam.view.parts.selection.measure.object.visible"), "and a line");
  await browser.key("Escape");
  await browser.until("return document.getElementById('picked').hidden", "no box");
  const keyframe = await clickOn(page, "keyframes");
  const seen = await browser.run(`let n = 0;
    for (const type of ["points", "segments"]) n += plslam.run.observersOf(type).rows.filter((row) => row === arguments[0]).length;
    return n;`, keyframe);
  check.that((await browser.run(rays)) === seen && seen > 10, `a keyframe has rays to its ${seen} landmarks`);
  await browser.key("Escape");
  await browser.run(`const { run, view } = plslam;
    [run.packedObservers, run.observers] = [null, {}];
    view.parts.selection.choose(run, { type: "points", row: arguments[0] });`, point);
  check.that((await page.text("#picked")).includes("not stored") && (await browser.run(rays)) === 0, "what a long run leaves out is said");
  await browser.key("Escape");
}

/** The address says what is looked at, and leads there again. */
async function checkAddress() {
  await browser.run("plslam.replay.go(7); document.getElementById('view-top').click()");
  await browser.until("return location.hash.includes('frame=')", "the view in the address");
  await browser.until("return location.hash.startsWith('#frame=' + plslam.run.frames.id[7] + '&')", "with the frame");
  const [hash, ...eye] = await browser.run("return [location.hash, ...plslam.view.camera.position.toArray()]");
  await browser.run("document.getElementById('view-all').click(); plslam.replay.go(2)");
  await browser.run("history.replaceState(null, '', arguments[0]); window.dispatchEvent(new Event('hashchange'))", hash);
  const [row, ...again] = await browser.run("return [plslam.replay.row, ...plslam.view.camera.position.toArray()]");
  const off = Math.max(...eye.map((x, k) => Math.abs(x - again[k])));
  check.that(row === 7 && off < 1e-3 * (1 + Math.hypot(...eye)), `the address '${hash}' leads back (row ${row}, eye ${off} m off)`);
  await browser.run("history.replaceState(null, '', '#frame=x&eye=1,2&target='); window.dispatchEvent(new Event('hashchange'))");
  check.that((await browser.run("return plslam.replay.row")) === 7, "nonsense in the address changes nothing");
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
  }
  await browser.run("plslam.replay.pause()");
}

await runChecks(check, browser, async (page) => {
  await page.open(pathToFileURL(resolve(file)).href);
  await checkFirstView();
  await checkLevel(page);
  await checkPanel(page);
  await checkStrength(page);
  await checkPick(page);
  await checkZoom(page);
  await checkAddress();
  await checkKeys();
});
