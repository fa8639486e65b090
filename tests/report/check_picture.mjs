// SPDX-License-Identifier: BSD-3-Clause
// node check_picture.mjs CHROMEDRIVER CHROMIUM REPORT.html [STEM]: checks the right image and the disparities of a
// report, and the features drawn on them; STEM is that of screenshots. Exit code 1 on failure.
import { writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file, stem] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);

/** Returns how unlike the images are at features of a type in both (both ends of segments), at the position given by their disparities, and 6 pixels beside it. */
const kUnlike = `
  const { shown, shrink } = plslam.picture;
  const { points, segments, segment_disparities: ends } = shown.features;
  const places = arguments[0] === "points" ? points
    : Array.from(ends).flatMap((d, i) => [segments[2 * i], segments[2 * i + 1], d]);
  const grey = async (jpeg) => {
    const image = new Image();
    image.src = "data:image/jpeg;base64," + jpeg;
    await image.decode();
    const canvas = new OffscreenCanvas(shown.width_px, shown.height_px);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0, shown.width_px, shown.height_px);
    const { data } = context.getImageData(0, 0, shown.width_px, shown.height_px);
    return (u, v) => data[4 * (Math.round(v) * shown.width_px + Math.round(u))];
  };
  return Promise.all([grey(shown.jpeg), grey(shown.right_jpeg)]).then(([left, right]) => {
    const unlike = (beside) => {
      let sum = 0, n = 0;
      for (let i = 0; i < places.length; i += 3) {
        const [u, v, d] = places.slice(i, i + 3);
        const at = (u - shrink * d) / 32 + beside;
        if (d === 65535 || at < 3 || at > shown.width_px - 4 || v / 32 > shown.height_px - 4 || v / 32 < 3 || u / 32 < 3 || u / 32 > shown.width_px - 4) continue;
        for (let k = -3; k <= 3; ++k, ++n) sum += Math.abs(left(u / 32 + k, v / 32) - right(at + k, v / 32));
      }
      return n ? sum / n : NaN;
    };
    return [unlike(0), unlike(-6), unlike(6)];
  });`;

async function checkRightImage(page) {
  const [pictures, rights] = await browser.run("const { pictures } = plslam.run; return [pictures.length, pictures.filter((p) => p.right_jpeg).length]");
  const button = "const button = document.getElementById('right-image'); return [button.hidden, button.getAttribute('aria-pressed')]";
  check.that(rights === pictures && pictures > 0, `${rights} of ${pictures} pictures have their right image`);
  const left = await page.look("#frame");
  check.that(left.colours > 200, `the picture of the frame is not blank: ${left.colours} colours`);
  if (stem) writeFileSync(`${stem}_left.png`, await browser.screenshot());
  await page.click("#right-image");
  await page.settle();
  check.that(`${await browser.run(button)}` === "false,true", "a button shows the right image");
  const right = await page.look("#frame");
  if (stem) writeFileSync(`${stem}_right.png`, await browser.screenshot());
  check.that(right.colours > 100 && right.digest !== left.digest, `which is another, and not blank: ${right.colours} colours`);
  for (const [type, share] of [["points", 0.75], ["segments", 0.85]]) {
    const [there, before, behind] = await browser.run(kUnlike, type);
    check.that(there < share * Math.min(before, behind), `its ${type} are where their disparities say: unlike by ${there}, beside it ${before} and ${behind}`);
    await page.switch(`${type}2d`, false);
    check.that((await page.look("#frame")).digest !== right.digest, `and are drawn`);
    await page.switch(`${type}2d`, true);
  }
  await browser.key("r", "r");
  await page.settle();
  check.that(`${await browser.run(button)}` === "false,false", "and the key R the left one again");
  // As with RGB-D.
  await browser.run("plslam.picture.kept = plslam.picture.shown; plslam.picture.shown = { ...plslam.picture.shown, right_jpeg: '' }; plslam.picture.load()");
  await browser.key("r", "r");
  check.that(`${await browser.run(button)}` === "true,false", "without a right image there is no button, and the key does nothing");
  await browser.run("plslam.picture.shown = plslam.picture.kept; plslam.picture.load()");
}

/** Returns the differences between the disparities of the picture and those of the points by vo_process. */
const kOff = `
  const { shown, shrink, matched: { width, disparities } } = plslam.picture;
  const { points } = shown.features;
  const off = [];
  let all = 0;
  for (let i = 0; i < points.length; i += 3) {
    const [u, v, d] = points.subarray(i, i + 3);
    if (d === 65535) continue;
    ++all;
    const x = Math.round((u / 32) * width / shown.width_px), y = Math.round((v / 32) * width / shown.width_px);
    const matched = disparities[y * width + x];
    if (matched > 0) off.push(Math.abs(matched - d / 32));
  }
  off.sort((a, b) => a - b);
  const known = disparities.filter((d) => d > 0).length / disparities.length;
  return [off[off.length >> 1], off.length / all, known];`;

async function checkDisparity(page) {
  const pressed = "return ['right-image', 'disparity'].map((id) => document.getElementById(id).getAttribute('aria-pressed'))";
  await page.slide("#time", Math.floor((await browser.run("return plslam.run.rows")) / 2));
  await page.settle();
  const left = await page.look("#frame");
  await browser.key("r", "r");
  await browser.key("d", "d");
  await page.settle();
  check.that(`${await browser.run(pressed)}` === "false,true", "the key D shows the disparity in the place of the right image");
  const seen = await page.look("#frame");
  if (stem) writeFileSync(`${stem}_disparity.png`, await browser.screenshot());
  check.that(seen.digest !== left.digest && seen.colours > 100, `which is another picture: ${seen.colours} colours`);
  const [off_px, share, known] = await browser.run(kOff);
  check.that(off_px < 0.7, `disparities are those of the points, as a rule: ${off_px} pixels off, at ${share} of the points`);
  check.that(share > 0.5 && known > 0.25, `and there are many: at ${known} of the pixels`);
  const legend = await page.text("#disparity-legend");
  check.that(/^far.* m.* c?m$/.test(legend), `a legend in metres: '${legend}'`);
  // The time on a busy machine; reading pixels back from a graphics card takes longer.
  const ms = await browser.run("const start = performance.now(); plslam.picture.load(); return plslam.picture.loaded.then(() => performance.now() - start)");
  check.that(ms < 5000, `after ${ms.toFixed(0)} ms`);
  await browser.key("d", "d");
  await page.settle();
  check.that(`${await browser.run(pressed)}` === "false,false" && (await page.look("#frame")).digest === left.digest, "and the left image again");
}

/** Checks that on a live page a picture may arrive before the camera, whose pixels are the unit of disparities. */
async function checkLateCamera() {
  const [before, after] = await browser.run(`
    const { picture, replay, run } = plslam;
    const before = picture.shrink, { camera } = run.facts;
    for (const known of [undefined, { ...camera, width_px: 2 * camera.width_px }]) {
      run.facts.camera = known;
      picture.show(run, replay.row);
    }
    return [before, picture.shrink];`);
  check.that(after === 0.5 * before, `of a camera twice as wide, which is told later, ${after} pixels of the picture for each: ${before}`);
}

await runChecks(check, browser, async (page) => {
  await page.open(pathToFileURL(resolve(file)).href);
  await checkRightImage(page);
  await checkDisparity(page);
  await checkLateCamera();
});
