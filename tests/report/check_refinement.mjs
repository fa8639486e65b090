// SPDX-License-Identifier: BSD-3-Clause
// node check_refinement.mjs CHROMEDRIVER CHROMIUM REPORT.html: checks the table of the refined map in the report of a
// run with --refine. Exit code 1 on failure.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, file] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);

await runChecks(check, browser, async (page) => {
  await page.open(pathToFileURL(resolve(file)).href);
  const [height, rows] = await browser.run(`return [document.getElementById("refinement").offsetHeight,
    [...document.querySelectorAll("#refinement-table tbody tr")].map((row) => [...row.cells].map((cell) => cell.textContent))];`);
  check.that(height > 0, "the report of a refined run has a table of it");
  const row = (name) => rows.find(([title]) => title === name) ?? [];
  check.that(row("Error (ATE)").slice(1).every((text) => /^[0-9.]+ m$/.test(text)) && row("Error (ATE)").length === 3,
    `the errors before and after are stated: ${row("Error (ATE)")}`);
  check.that(rows.length >= 9, `${rows.length} rows`);
});
