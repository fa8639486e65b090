// SPDX-License-Identifier: BSD-3-Clause
// node check_end.mjs CHROMEDRIVER CHROMIUM URL: opens the live page of a run, says "watching", and sees the run end, whenever that
// is (live_test.mjs knows what it says afterwards). Exit code 1 where something is wrong.
import { Browser } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, url] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);
await runChecks(check, browser, async (page) => {
  await page.open(url);
  console.log("watching");
  await browser.until("return document.getElementById('kicker').textContent.includes('finished')", "the page says 'finished'", 30);
  check.that(await browser.run("return plslam.run.facts.finished"), "it has the data of the end");
});
