// SPDX-License-Identifier: BSD-3-Clause
// Polls the viewer for new data, more slowly if that is much work, and at once when it reports the end of the run,
// because it may exit soon after.

const kShortest_ms = 700;
const kLongest_ms = 8000;

const after = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Resolves when the viewer reports the end of the run.
async function end() {
  for (;;) {
    try {
      const response = await fetch("end", { cache: "no-store" });
      if (response.ok && (await response.text()).startsWith("finished")) return;
    } catch {
      await after(kShortest_ms);
    }
  }
}

export async function follow(run, changed, tell) {
  let failures = 0;
  let over = false;
  let ended = null;
  for (;;) {
    const start = performance.now();
    ended ??= end().then(() => { over = true; });
    try {
      const response = await fetch(`data.json?since=${encodeURIComponent(run.next)}`, { cache: "no-store" });
      if (!response.ok) throw new Error(`${response.status}`);
      changed(run.take(await response.json()));
      // The time for drawing counts, too.
      await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
      failures = 0;
      // Another run has begun.
      if (over && !run.facts.finished) {
        over = false;
        ended = null;
      }
      tell(run.facts.finished ? "finished" : "live");
    } catch (error) {
      ++failures;
      tell(over || run.facts.finished ? "finished" : "connection lost");
      if (!(error instanceof TypeError) && !/^\d+$/.test(error.message)) throw error;
    }
    const spent = performance.now() - start;
    const pause = after(run.facts.finished ? kLongest_ms : Math.min(kLongest_ms, Math.max(kShortest_ms, 4 * spent, failures * 1000)));
    await (over ? pause : Promise.race([pause, ended]));
  }
}
