// SPDX-License-Identifier: BSD-3-Clause
// node --test orders_test.mjs: tests the proofs of orders against another implementation.
import assert from "node:assert/strict";
import { createHmac } from "node:crypto";
import { test } from "node:test";
import { proofOf } from "../../viewer_headless/page/orders.js";

test("an order is proved by an HMAC of challenge, verb and file", async () => {
  const key = "00ff".repeat(16);
  const challenge = "0123456789abcdef".repeat(2);
  for (const [verb, file] of [["pause", ""], ["save", "--force /out/räume.plmap"]]) {
    const expected = createHmac("sha256", Buffer.from(key, "hex")).update(`${challenge}\n${verb}\n${file}`, "utf8").digest("hex");
    assert.equal(await proofOf(key, challenge, verb, file), expected);
    assert.equal(await proofOf(key.toUpperCase(), challenge, verb, file), expected);
  }
});
