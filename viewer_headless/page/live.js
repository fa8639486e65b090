// Asks the viewer again and again for what is new, ever more slowly where that is much work.

const kShortest_ms = 700;
const kLongest_ms = 8000;

export async function follow(run, changed, tell) {
  let failures = 0;
  for (;;) {
    const start = performance.now();
    try {
      const response = await fetch(`data.json?since=${encodeURIComponent(run.next)}`, { cache: "no-store" });
      if (!response.ok) throw new Error(`${response.status}`);
      changed(run.take(await response.json()));
      // What the drawing takes counts too.
      await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
      failures = 0;
      tell(run.facts.finished ? "finished" : "live");
    } catch (error) {
      ++failures;
      tell("connection lost");
      if (!(error instanceof TypeError) && !/^\d+$/.test(error.message)) throw error;
    }
    const spent = performance.now() - start;
    const pause = run.facts.finished ? kLongest_ms : Math.min(kLongest_ms, Math.max(kShortest_ms, 4 * spent, failures * 1000));
    await new Promise((resolve) => setTimeout(resolve, pause));
  }
}
