// SPDX-License-Identifier: BSD-3-Clause
// Table of the loops of the run, with the pictures of their two keyframes.
import { byId, element } from "./element.js";
import { fixed, metres } from "./format.js";

function thumbnail(jpeg, label) {
  if (!jpeg) return element("div", { class: "thumb none" }, "no picture");
  return element("img", { class: "thumb", src: `data:image/jpeg;base64,${jpeg}`, alt: label, loading: "lazy" });
}

const kColumns = [
  ["frames", (l) => `${l.old_frame < 0 ? "–" : l.old_frame} ↔ ${l.frame < 0 ? "–" : l.frame}`],
  ["similarity", (l) => (l.score > 0 ? fixed(l.score, 3) : "–")],
  ["points", (l) => `${l.points}`],
  ["lines", (l) => `${l.lines}`],
  ["apart", (l) => metres(l.distance_m)],
  ["turned", (l) => `${fixed(l.angle_deg, 1)}°`],
  ["map moved", (l) => (l.moved_m > 0 ? metres(l.moved_m) : "–")],
  ["time", (l) => (l.correct_ms > 0 ? `${fixed(l.detect_ms + l.correct_ms, 0)} ms` : "–")],
];

export function showLoops(run, choose) {
  byId("loops").hidden = run.loops.length === 0;
  if (!run.loops.length) return;
  byId("loops-lead").textContent = `${run.loops.length} pairs of keyframes that see the same place. Select a row to show its frames and its correction above.`;
  const head = element("tr", {}, element("th", {}, "earlier"), element("th", {}, "later"), ...kColumns.map(([name]) => element("th", {}, name)));
  const rows = run.loops.map((loop, i) => element("tr", { tabindex: 0, onclick: () => choose(loop, i), onkeydown: (e) => e.key === "Enter" && choose(loop, i) },
    element("td", {}, thumbnail(loop.old_jpeg, `frame ${loop.old_frame}`)),
    element("td", {}, thumbnail(loop.jpeg, `frame ${loop.frame}`)),
    ...kColumns.map(([name, text]) => element("td", { "data-name": name }, text(loop)))));
  byId("loop-table").replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
}

export function markLoop(index) {
  document.querySelectorAll("#loop-table tbody tr").forEach((row, i) => row.classList.toggle("chosen", i === index));
}
