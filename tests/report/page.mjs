// SPDX-License-Identifier: BSD-3-Clause
// Common parts of the checks of the page of reports.
import { decodePng, eachPixel } from "./png.mjs";

export class Check {
  constructor() {
    this.failures = 0;
  }

  /** Prints failures with their numbers, and continues. */
  that(good, what) {
    if (!good) ++this.failures;
    console.log(`${good ? "ok  " : "FAIL"} ${what}`);
  }
}

const kNear = 60;

export class Page {
  constructor(browser) {
    this.browser = browser;
  }

  async open(url) {
    await this.browser.resize(1100, 800);
    // Otherwise another hash of the same page would not reload it.
    await this.browser.go("about:blank");
    await this.browser.go(url);
    await this.browser.until("return !!window.plslam && window.plslam.run.rows > 0", "data of a run");
    await this.settle();
  }

  /** Waits until the map has been drawn twice more and the picture is loaded. */
  async settle() {
    await this.browser.run(`
      const wait = () => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
      document.getElementById("stage").scrollIntoView();
      const loaded = () => plslam.picture.loaded;
      return wait().then(loaded).then(wait);`);
  }

  box(selector) {
    return this.browser.run("return document.querySelector(arguments[0]).getBoundingClientRect().toJSON()", selector);
  }

  text(selector) {
    return this.browser.run("return document.querySelector(arguments[0]).textContent", selector);
  }

  /** Returns an object that a click selects, of the type ("points", "segments", "keyframes") and run (0: the page's own), but not `avoid` ([[type, row]]): {row, at: [x, y]}; row -1 if there is none. */
  async findPickable(type, of = 0, avoid = []) {
    const [row, ...at] = await this.browser.run(`
      const [type, of, avoid] = arguments;
      const { view, run } = plslam;
      const box = view.canvas.getBoundingClientRect();
      const of_run = of ? run.others[of - 1] : run;
      const n = (of_run.map[type].seen ?? of_run.map[type].frame).length;
      for (let row = 0; row < n; ++row) {
        if (avoid.some(([t, r]) => t === type && r === row)) continue;
        const at = view.picker.pixelOf(view.parts.selection.placeOf(run, { type, row, of }));
        // Integer pixels of the window, like a mouse.
        const [x, y] = at ? [Math.round(box.x + at[0]), Math.round(box.y + at[1])] : [-1, -1];
        if (document.elementFromPoint(x, y) !== view.canvas) continue;
        const picked = view.picker.pick(Math.round(x - box.x), Math.round(y - box.y));
        if (picked?.type === type && picked.row === row && picked.of === of) return [row, x, y];
      }
      return [-1, 0, 0];`, type, of, avoid);
    return { row, at };
  }

  /** Returns the address after the view has come to rest and the address is written. */
  async address() {
    await this.browser.until("return !plslam.view.pending && plslam.address.timer === null", "a view at rest and its address", 60);
    return Object.fromEntries(new URLSearchParams((await this.browser.run("return location.hash")).slice(1)));
  }

  click(selector) {
    return this.browser.run("document.querySelector(arguments[0]).click()", selector);
  }

  /** Moves it like a user. */
  slide(selector, value) {
    return this.browser.run(`const slider = document.querySelector(arguments[0]);
      slider.value = arguments[1];
      slider.dispatchEvent(new Event("input", { bubbles: true }));`, selector, value);
  }

  async switch(layer, on) {
    await this.browser.run(`const box = document.querySelector("[name=" + arguments[0] + "]");
      if (box.checked !== arguments[1]) box.click();`, layer, on);
    await this.settle();
  }

  /** Returns for an element on the screen: pixels near a colour of the style, number of colours, pixels unlike the corner, and a digest of all its pixels, which differs for another picture. */
  async look(selector, names = []) {
    const wanted = await this.browser.run(`return arguments[0].map((name) => {
      const hex = getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
      return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
    })`, names);
    const box = await this.box(selector);
    const seen = { colours: new Set(), drawn: 0, digest: 0, near: Object.fromEntries(names.map((name) => [name, 0])) };
    let ground = null;
    eachPixel(decodePng(await this.browser.screenshot()), box, (r, g, b) => {
      ground ??= [r, g, b];
      const colour = (r << 16) | (g << 8) | b;
      seen.colours.add(colour);
      seen.digest = (Math.imul(seen.digest, 31) + colour) | 0;
      if (Math.abs(r - ground[0]) + Math.abs(g - ground[1]) + Math.abs(b - ground[2]) > kNear) ++seen.drawn;
      names.forEach((name, i) => {
        const [wr, wg, wb] = wanted[i];
        if (Math.abs(r - wr) + Math.abs(g - wg) + Math.abs(b - wb) < kNear) ++seen.near[name];
      });
    });
    return { ...seen, colours: seen.colours.size };
  }

  /** Returns errors of the console since the last call. */
  async errors() {
    const entries = await this.browser.log();
    return entries.filter((entry) => entry.level === "SEVERE").map((entry) => entry.message);
  }
}

/** Calls `work(page)`, checks the console for errors, and ends this process: exit code 1 on failure. */
export async function runChecks(check, browser, work) {
  try {
    const page = new Page(browser);
    await work(page);
    const errors = await page.errors();
    check.that(errors.length === 0, `no errors in the console ${errors.join("; ")}`);
  } catch (error) {
    check.that(false, error.stack);
  } finally {
    await browser.close();
  }
  process.exit(check.failures ? 1 : 0);
}
