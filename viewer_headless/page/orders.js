// SPDX-License-Identifier: BSD-3-Clause
// Buttons of a live page that give orders to the run, as `plslam pause`, `resume`, `save` and `reset` do.
import { byId } from "./element.js";

const kOrders = {
  pause: { text: "Pause the player or camera?", confirm: "Pause" },
  resume: { text: "Resume the player or camera?", confirm: "Resume" },
  save: { text: "Save the map of this run.", confirm: "Save", always: true },
  reset: { text: "Start a new, empty map? What is not saved is lost.", confirm: "New map", always: true },
};

/** The key of the bus; it stays in this page. */
let key = "";

function bytesOfHex(text) {
  return Uint8Array.from(text.match(/../g) ?? [], (digits) => parseInt(digits, 16));
}

/** Returns the proof of an order (viewer_headless/live/order_proof.h). */
export async function proofOf(hexKey, challenge, verb, argument) {
  const hmac = { name: "HMAC", hash: "SHA-256" };
  const imported = await crypto.subtle.importKey("raw", bytesOfHex(hexKey), hmac, false, ["sign"]);
  const text = new TextEncoder().encode(`${challenge}\n${verb}\n${argument}`);
  return Array.from(new Uint8Array(await crypto.subtle.sign("HMAC", imported, text)), (b) => b.toString(16).padStart(2, "0")).join("");
}

/** Opens the dialog for what the order needs; resolves to its argument, or to null if it is not to be given. */
function ask(verb, { needs_key, file }) {
  const { text, confirm, always } = kOrders[verb];
  if (!always && !(needs_key && !key)) return Promise.resolve("");
  const saves = verb === "save";
  byId("order-text").textContent = text;
  byId("order-confirm").textContent = confirm;
  byId("order-file-box").hidden = byId("order-force-box").hidden = !saves;
  byId("order-file").required = saves;
  byId("order-file").value ||= file;
  byId("order-force").checked = false;
  byId("order-key-box").hidden = !needs_key || !!key;
  byId("order-key").required = needs_key && !key;
  byId("order-key").pattern = "[0-9A-Fa-f]{64}";
  const dialog = byId("order");
  dialog.returnValue = "";
  dialog.showModal();
  return new Promise((resolve) => dialog.addEventListener("close", () => {
    if (dialog.returnValue !== "confirm") return resolve(null);
    key ||= byId("order-key").value;
    byId("order-key").value = "";
    resolve(saves ? (byId("order-force").checked ? "--force " : "") + byId("order-file").value : "");
  }, { once: true }));
}

async function give(verb) {
  const description = await (await fetch("orders", { cache: "no-store" })).json();
  const argument = await ask(verb, description);
  if (argument === null) return "";
  byId("order-result").textContent = "…";
  const headers = { "X-PLSLAM-Order": "1", "Content-Type": "text/plain;charset=utf-8" };
  if (description.needs_key) headers["X-PLSLAM-Proof"] = await proofOf(key, description.challenge, verb, argument);
  const response = await fetch(`orders/${verb}`, { method: "POST", headers, body: argument });
  if (response.status === 401) key = "";
  return (await response.text()).trim();
}

export function makeOrders() {
  const buttons = Object.keys(kOrders).map((verb) => [verb, byId(`order-${verb}`)]);
  for (const [verb, button] of buttons) {
    button.addEventListener("click", async () => {
      for (const [, other] of buttons) other.disabled = true;
      try {
        byId("order-result").textContent = await give(verb);
      } catch (error) {
        byId("order-result").textContent = `${verb}: ${error.message}`;
      } finally {
        for (const [, other] of buttons) other.disabled = false;
      }
    });
  }
}

/** Shows the buttons while the run can receive orders. */
export function showOrders(state) {
  byId("orders").hidden = state !== "live";
}
