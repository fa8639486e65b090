// SPDX-License-Identifier: BSD-3-Clause
// node check_live.mjs CHROMEDRIVER CHROMIUM URL PID: opens the live page of a continuing run and checks that it grows.
// PID is that of its vo_process, which is stopped for a moment. Finally prints "watching" and waits for the end of the
// run (live_test.mjs checks the states afterwards). Exit code 1 on failure.
import { Browser, kShift } from "./browser.mjs";
import { Check, runChecks } from "./page.mjs";

const [chromedriver, chromium, url, pid] = process.argv.slice(2);
const check = new Check();
const browser = await Browser.open(chromedriver, chromium);
const kProcesses = `return Object.fromEntries([...document.querySelectorAll("#process-table tbody tr")].map((row) =>
  [row.dataset.process, Object.fromEntries([...row.children].map((cell) => [cell.dataset.name, cell.textContent]))]))`;

/** Checks that a stopped vo_process falls behind and then catches up. */
async function checkLag() {
  const behind = "return Math.max(-1, ...plslam.run.processes.filter((p) => p.name === 'vo').map((p) => p.lag_frames))";
  const before = await browser.run(behind);
  process.kill(Number(pid), "SIGSTOP");
  try {
    await browser.until(`${behind} > ${before} + 30`, "a vo_process that is behind", 20);
    await browser.until("return /silent/.test(document.querySelector('#process-table [data-process=vo] [data-name=state]').textContent)", "that says nothing");
    const { vo } = await browser.run(kProcesses);
    check.that(parseInt(vo.lag) > before + 30 && /s\)/.test(vo.lag), `one that is held up is behind: ${JSON.stringify(vo)}`);
    const { mapping } = await browser.run(kProcesses);
    check.that(parseInt(mapping.lag) < parseInt(vo.lag), `and it alone: ${JSON.stringify(mapping)}`);
  } finally {
    process.kill(Number(pid), "SIGCONT");
  }
  await browser.until(`${behind} < ${before} + 20`, "a vo_process that has caught up", 30);
}

/** Checks that a measured distance stays while the map grows. */
async function checkMeasured(page) {
  // The map changes between the look and the click.
  const click = async (type, avoid, keys, done) => {
    for (let i = 0; i < 8 && !(await browser.run(done)); ++i) {
      const { row, at } = await page.findPickable(type, 0, avoid);
      if (row >= 0) await browser.press(at, at, 1, keys);
    }
    await browser.until(done, "something chosen");
  };
  await click("keyframes", [], 0, "return !!plslam.view.parts.selection.picked");
  const first = await browser.run("const { type, row } = plslam.view.parts.selection.picked; return [type, row]");
  await click("keyframes", [first], kShift, "return !!plslam.view.parts.selection.other");
  const ids = "const { selection } = plslam.view.parts; return [selection.textOf(selection.picked, selection.id), selection.textOf(selection.other, selection.otherId)].join()";
  const before = await browser.run(ids);
  await browser.run("window.oldMap = plslam.run.map");
  await browser.until("return plslam.run.map !== window.oldMap", "another map", 30);
  await page.settle();
  const [after, seen] = [await browser.run(ids), await browser.run("return !document.getElementById('measured').hidden && document.getElementById('picked').textContent.includes('distance')")];
  check.that(after === before && seen, `what was measured stays in another map: ${before}, then ${after}, ${seen}`);
  await browser.key("Escape");
}

/** Checks that the address is written, and read during the run. */
async function checkAddress(page) {
  await browser.run("document.activeElement.blur(); plslam.replay.go(7)");
  await browser.key("ArrowRight");
  await page.click("#view-top");
  await page.click("[data-mode=life]");
  // If a slow machine skips frames, it is not the eighth.
  const [frame, keyframe] = await browser.run("return [plslam.run.frames.id[8], plslam.run.map.keyframes.id[0]]");
  const address = await page.address();
  check.that(address.frame === `${frame}` && address.view === "top", `the address tells frame ${frame} and view: ${JSON.stringify(address)}`);
  await page.open(`${url}#frame=${frame}&view=top&colour=life&layers=-keyframes&pick=keyframes:${keyframe}`);
  await browser.until("return plslam.run.map && !!plslam.view.parts.selection.picked", "what the address asks for");
  const state = await browser.run("const { view, replay } = plslam; return [replay.run.frames.id[replay.row], view.fromAbove, view.colourMode, view.layers.get('keyframes'), view.parts.selection.id]");
  check.that(`${state}` === `${frame},true,life,false,${keyframe}`, `a live page shows what its address says: ${state}`);
  await page.open(`${url}`);
  const following = await page.address();
  check.that(following.frame === undefined && following.view === "all", "and one that follows the run goes on doing so");
}

/** Checks that the buttons pause and resume the run, save its map, and start a new one. */
async function checkOrders(page) {
  const result = "return document.getElementById('order-result').textContent";
  const says = (text, what) => browser.until(`return document.getElementById('order-result').textContent.includes(${JSON.stringify(text)})`, what, 60);
  await page.click("#order-pause");
  await says("paused", "a run that is paused");
  await page.click("#order-save");
  await browser.until("return document.getElementById('order').open", "the question for a file");
  const [file, asksKey] = await browser.run("return [document.getElementById('order-file').value, !document.getElementById('order-key-box').hidden]");
  check.that(file.endsWith("/map.plmap") && !asksKey, `the proposed file: ${file}`);
  // Keys for the file do not reach the page.
  const view = await browser.run("document.getElementById('order-file').focus(); return plslam.view.fromAbove");
  await browser.key("2");
  await browser.key("Backspace");
  check.that((await browser.run("return plslam.view.fromAbove")) === view, "a digit of a file name is no key of the page");
  await browser.run("document.getElementById('order-file').value = arguments[0]", file);
  await page.click("#order-confirm");
  await says(`the map is saved in ${file}`, "a map that is saved");
  await page.click("#order-reset");
  await browser.until("return document.getElementById('order').open", "a question before a map is lost");
  await page.click("#order [value=cancel]");
  // Until it has reacted to the end of the question, after the dialog is closed, the page takes no clicks.
  await browser.until("return !document.getElementById('order').open && !document.getElementById('order-resume').disabled", "the end of the question");
  check.that(!(await browser.run(result)).includes("new map"), `nothing is lost by Cancel: '${await browser.run(result)}'`);
  await page.click("#order-resume");
  await says("resumed", "a run that is resumed");
}

await runChecks(check, browser, async (page) => {
  await page.open(url);
  const first = await browser.run("return plslam.run.rows");
  check.that((await page.text("#kicker")).includes("live"), `it says that it is live: '${await page.text("#kicker")}'`);
  await browser.until(`return plslam.run.rows > ${first} + 5`, "more frames");
  await browser.until("return plslam.run.map && plslam.run.map.points.seen.length > 50", "a map");
  await browser.until("return plslam.run.pictures.length > 0", "a picture");
  const rows = await browser.run("return plslam.run.rows");
  check.that(rows > first, `frames come: ${first}, then ${rows}`);
  await page.settle();
  const seen = await page.look("#map", ["path"]);
  check.that(seen.drawn > 500 && seen.near.path > 30, `and are drawn: ${seen.drawn} pixels, ${seen.near.path} of the path`);
  for (const name of ["player", "vo", "mapping", "loop", "viewer"]) {
    // A process that gets no CPU time is silent for a while.
    await browser.until(`const cell = document.querySelector("#process-table [data-process=${name}] [data-name=state]");
      return !!cell && /running|ready|finished/.test(cell.textContent)`, `how ${name} is`, 30);
  }
  const processes = await browser.run(kProcesses);
  for (const [name, p] of Object.entries(processes)) {
    const lag = /^(vo|mapping|loop)$/.test(name) ? /^\d+ frames?( \(.* s\))?$/ : /^–$/;
    check.that(p.restarts === "0" && lag.test(p.lag), `how ${name} is: ${JSON.stringify(p)}`);
  }
  check.that(/ ms$/.test(processes.vo.work) && /ms per update/.test(processes.mapping.work), "and what a frame takes");
  const ids = await browser.run("return Array.from(plslam.run.frames.id)");
  check.that(ids.every((id, i) => i === 0 || id > ids[i - 1]), "each frame once, in order");
  const columns = await browser.run("return Object.entries(plslam.run.frames).map(([name, c]) => [name, c.length / plslam.run.frameWidths[name]])");
  check.that(columns.every(([, n]) => n === columns[0][1]), `columns are equally long: ${columns}`);
  await checkOrders(page);
  await checkMeasured(page);
  await checkAddress(page);
  await checkLag();
  console.log("watching");
  await browser.until("return document.getElementById('kicker').textContent.includes('finished')", "the page says 'finished'", 30);
  check.that(await browser.run("return plslam.run.facts.finished"), "it has the data of the end");
  check.that(await browser.run("return document.getElementById('orders').hidden"), "and no buttons any more");
});
