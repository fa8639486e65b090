// node check_end.mjs CHROMEDRIVER CHROMIUM URL: opens the live page of a run, says "watching", and sees the run end, whenever that
// is. Exit code 1 where something is wrong.
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
  // Whoever served it is gone; the page asks for another run every 8 s.
  await new Promise((resolve) => setTimeout(resolve, 9500));
  const kicker = await page.text("#kicker");
  check.that(kicker.includes("finished"), `and still says so when nobody answers any more: '${kicker}'`);
  const others = (await page.errors()).filter((message) => !/data\.json|\/end/.test(message));
  check.that(others.length === 0, `the console tells of nothing else than that: ${others.join("; ")}`);
});
