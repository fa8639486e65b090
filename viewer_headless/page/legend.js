// SPDX-License-Identifier: BSD-3-Clause
// Legend of the colours of the points.
import { byId, element } from "./element.js";
import { cssGradient, scales } from "./colours.js";
import { fixed } from "./format.js";

const kTitles = { height: "height", seen: "first seen in frame", life: "seen over (frames)", observations: "observed by keyframes" };
const kUnits = { height: " m", seen: "", life: "", observations: "" };

export function showLegend(mode, range) {
  const digits = mode === "height" && range && Math.abs(range[1] - range[0]) < 10 ? 1 : 0;
  const box = byId("legend");
  box.hidden = !range;
  if (!range) return;
  box.replaceChildren(
    element("span", {}, kTitles[mode]),
    element("i", { style: `background: ${cssGradient(scales[mode])}` }),
    element("span", { class: "ends" }, ...range.map((value) => element("b", {}, `${fixed(value, digits)}${kUnits[mode]}`))),
  );
}

/** Makes buttons of which one is pressed; `choose(mode)` is called. Returns a function that presses one. */
export function makeColourChoice(choose) {
  const names = { height: "Height", seen: "Age", life: "Life", observations: "Observations" };
  const press = (mode) => {
    if (!Object.hasOwn(names, mode)) return;
    for (const button of buttons) button.setAttribute("aria-pressed", button.dataset.mode === mode);
    choose(mode);
  };
  const buttons = Object.entries(names).map(([mode, label]) =>
    element("button", { type: "button", "data-mode": mode, "aria-pressed": mode === "height" ? "true" : "false",
      onclick: () => press(mode) }, label));
  byId("colours").append(...buttons);
  return press;
}
