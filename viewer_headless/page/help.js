// SPDX-License-Identifier: BSD-3-Clause
// What mouse and keys do, in a box.
import { byId, element } from "./element.js";

const kActions = [
  ["Map", [
    ["drag", "turn around what is looked at"],
    ["right button, or Ctrl and drag", "move sideways"],
    ["wheel", "nearer, further"],
    ["click", "choose a landmark or keyframe"],
    ["Shift and click", "the distance from what is chosen"],
    ["double click", "turn around what was clicked"],
    ["1, 2, 3", "whole map, from above, fly along the path"],
    ["Esc", "choose nothing"],
  ]],
  ["Picture", [
    ["R", "right image"],
    ["D", "disparity"],
    ["F, or a click", "large, and back (also Esc)"],
  ]],
  ["Time", [
    ["Space", "play, pause"],
    ["← →", "a frame (with Shift ten)"],
    ["click in a figure", "go there"],
    ["drag in a figure", "a part of the time; double click: all"],
  ]],
  ["Page", [["?", "this box"]]],
];

export function makeHelp() {
  const dialog = byId("help");
  const parts = kActions.map(([title, actions]) => element("section", {}, element("h3", {}, title),
    element("dl", {}, ...actions.flatMap(([what, does]) => [element("dt", {}, what), element("dd", {}, does)]))));
  dialog.append(element("button", { type: "button", class: "close", "aria-label": "Close", onclick: () => dialog.close() }, "×"),
    element("h2", {}, "Mouse and keys"), ...parts);
  // A click beside it.
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  byId("help-button").addEventListener("click", () => (dialog.open ? dialog.close() : dialog.showModal()));
}
