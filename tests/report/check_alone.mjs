// SPDX-License-Identifier: BSD-3-Clause
// node check_alone.mjs CHROMEDRIVER CHROMIUM REPORT.html: whether a report that is opened and used asks for nothing but itself.
// Exit code 1 where something is wrong.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file] = process.argv.slice(2);
const url = pathToFileURL(resolve(file)).href;
const check = new Check();
const browser = await Browser.open(chromedriver, chromium, { network: true });

async function checkAlone() {
  const asked = (await browser.requests()).filter((asked) => !asked.startsWith("data:"));
  check.that(asked.length > 0 && asked.every((address) => address.split("#")[0] === url), `it asks for nothing but itself: ${[...new Set(asked)]}`);
  const entries = await browser.run("return performance.getEntriesByType('resource').map((e) => e.name).filter((name) => !name.startsWith('data:'))");
  check.that(entries.length === 0, `nor does the page know of more: ${entries}`);
}

/** The page could not, even if it wanted to; and what it did would be seen here. */
async function checkPolicy() {
  await browser.run("const image = new Image(); image.src = 'http://127.0.0.1:9/x.png'; return fetch('http://127.0.0.1:9/').catch(() => 0)");
  const said = (await browser.log()).map((entry) => entry.message);
  check.that(said.filter((message) => message.includes("Content Security Policy")).length >= 2, `its policy forbids more: ${said.join("; ")}`);
}

await runChecks(check, browser, async (page) => {
  // The page that Chromium begins with is its own.
  await browser.go("about:blank");
  await browser.requests();
  await page.open(url);
  await page.click("#disparity");
  await page.click("#help-button");
  await browser.run("for (const id of ['processes', 'plots', 'loops']) document.getElementById(id).scrollIntoView()");
  await page.settle();
  const errors = await page.errors();
  check.that(errors.length === 0, `no errors in the console before ${errors.join("; ")}`);
  await checkAlone();
  await checkPolicy();
});
