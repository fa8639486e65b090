// SPDX-License-Identifier: BSD-3-Clause
// Dialog with the functions of mouse and keys.
import { byId, element } from "./element.js";

const kActions = [
  ["Map", [
    ["drag", "rotate around the centre of the view"],
    ["right button, or Ctrl and drag", "move sideways"],
    ["wheel", "nearer, further"],
    ["click", "select a landmark or keyframe"],
    ["Shift and click", "distance from the selection"],
    ["double click", "rotate around the clicked object"],
    ["1, 2, 3", "whole map, from above, fly along the path"],
    ["Esc", "clear the selection"],
  ]],
  ["Picture", [
    ["R", "right image"],
    ["D", "disparity"],
    ["F, or a click", "large, and back (also Esc)"],
  ]],
  ["Time", [
    ["Space", "play, pause"],
    ["← →", "one frame (with Shift: ten)"],
    ["click in a figure", "go there"],
    ["drag in a figure", "zoom in time; double click: whole run"],
  ]],
  ["Page", [["?", "this help"]]],
];

export function makeHelp() {
  const dialog = byId("help");
  const parts = kActions.map(([title, actions]) => element("section", {}, element("h3", {}, title),
    element("dl", {}, ...actions.flatMap(([what, does]) => [element("dt", {}, what), element("dd", {}, does)]))));
  dialog.append(element("button", { type: "button", class: "close", "aria-label": "Close", onclick: () => dialog.close() }, "×"),
    element("h2", {}, "Mouse and keys"), ...parts);
  // A click outside the dialog.
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  byId("help-button").addEventListener("click", () => (dialog.open ? dialog.close() : dialog.showModal()));
}
