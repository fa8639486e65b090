// SPDX-License-Identifier: BSD-3-Clause
// node --test live_test.mjs: tests the states of a live page while its viewer answers, at the end of the run, and
// without answers.
import assert from "node:assert/strict";
import { test } from "node:test";
import { follow } from "../../viewer_headless/page/live.js";

// A hundred times faster.
const plainTimeout = setTimeout;
globalThis.setTimeout = (f, ms = 0) => plainTimeout(f, ms / 100);
globalThis.requestAnimationFrame = (f) => plainTimeout(f, 0);

const kRefused = new TypeError("fetch failed");

class FakeRun {
  facts = { finished: false };
  next = "";
  take(json) {
    this.facts = json;
    return new Set(["facts"]);
  }
}

/** Returns the states in order, each once, for a viewer that answers with `data` one after the other. */
async function statesFor(data, end) {
  const states = [];
  globalThis.fetch = async (url) => {
    if (url === "end") return end();
    if (data.length === 0) throw new Error("no more");
    const answer = data.shift();
    if (answer === kRefused) throw kRefused;
    return { ok: true, json: async () => (typeof answer === "function" ? answer() : answer) };
  };
  await assert.rejects(follow(new FakeRun(), () => {}, (state) => states.at(-1) !== state && states.push(state)), /no more/);
  return states;
}

const kFinished = async () => ({ ok: true, text: async () => "finished\n" });
const kNever = () => new Promise(() => {});

test("a viewer that is gone in the middle is a connection that is lost", async () => {
  assert.deepEqual(await statesFor([{ finished: false }, kRefused, { finished: false }, kRefused], kNever),
    ["live", "connection lost", "live", "connection lost"]);
});

test("a run that is over stays finished when nobody answers any more", async () => {
  assert.deepEqual(await statesFor([{ finished: false }, { finished: true }, kRefused], kNever), ["live", "finished"]);
});

test("whoever was told of the end knows it without the last data", async () => {
  const over = [];
  const end = () => new Promise((resolve) => over.push(() => resolve({ ok: true, text: async () => "finished\n" })));
  const data = [{ finished: false }, () => { over.forEach((f) => f()); return { finished: true }; }, kRefused];
  assert.deepEqual(await statesFor(data, end), ["live", "finished"]);
  assert.deepEqual(await statesFor([{ finished: true }, kRefused], kFinished), ["finished"]);
});

test("at the end data are asked for at once, however long the pause is", async () => {
  globalThis.setTimeout = (f, ms = 0) => (ms < 700 ? plainTimeout(f, 0) : undefined);
  const states = [];
  await new Promise((asked) => {
    const answers = [{ finished: false }, { finished: true }];
    globalThis.fetch = async (url) => {
      if (url === "end") {
        // After the first data have been drawn, in a pause that never ends.
        while (states.length === 0) await new Promise((resolve) => plainTimeout(resolve, 1));
        return kFinished();
      }
      const answer = answers.shift();
      if (answer.finished) asked();
      return { ok: true, json: async () => answer };
    };
    follow(new FakeRun(), () => {}, (state) => states.push(state));
  });
  assert.deepEqual(states, ["live"]);
});
