// SPDX-License-Identifier: BSD-3-Clause
// Switches of the drawn layers.
import { byId, element } from "./element.js";

// `swatch` is the appearance: [shape, colour of the style].
const kGroups = [
  ["Map", [
    { name: "points", label: "Points", on: true, swatch: ["dots", "heights"] },
    { name: "segments", label: "Segments", on: true, swatch: ["thin", "heights"] },
    { name: "keyframes", label: "Keyframes", on: true, swatch: ["frustum", "keyframe"] },
    { name: "covisibility", label: "Covisibility", on: false, swatch: ["thin", "covisible"] },
    { name: "essential", label: "Essential", on: false, swatch: ["thin", "essential"] },
    { name: "loopEdges", label: "Loops", on: true, swatch: ["thin", "loop"] },
  ]],
  ["Surfaces", [
    { name: "surface", label: "Surfaces", on: true, swatch: ["dots", "surface"] },
    { name: "floor", label: "Grid", on: true, swatch: ["grid", "occupied"] },
  ]],
  ["Path", [
    { name: "path", label: "Estimated", on: true, swatch: ["thick", "path"] },
    { name: "truth", label: "True", on: true, swatch: ["thick", "truth"] },
    { name: "live", label: "As published", on: false, swatch: ["thick", "live"] },
    { name: "odom", label: "Odometry", on: false, swatch: ["thick", "odom"] },
  ]],
  ["Picture", [
    { name: "points2d", label: "Points", on: true, swatch: ["ring", "path"] },
    { name: "segments2d", label: "Segments", on: true, swatch: ["thick", "essential"] },
  ]],
];

/** Returns the switches of a page of several runs; without others, those of one run. */
function groupsWith({ name, others }) {
  if (!others.length) return kGroups;
  const layers = others.map(({ label }, i) => ({ name: `other${i}`, label, on: true, swatch: ["thick", `other${i}`] }));
  return [["Runs", [{ name: "own", label: name, on: true, swatch: ["thick", "path"] }, ...layers]], ...kGroups];
}

/** A map of name to boolean; `changed(name)` is called after a switch. */
export function makeLayers(others, changed) {
  const groups = groupsWith(others);
  const layers = new Map(groups.flatMap(([, group]) => group.map((layer) => [layer.name, layer.on])));
  for (const [title, group] of groups) {
    byId("layers").append(element("div", { class: "group" }, element("span", { class: "group-name" }, title),
      ...group.map((layer) => switchOf(layer, (on) => {
        layers.set(layer.name, on);
        changed(layer.name);
      }))));
  }
  return layers;
}

/** Returns the switches that differ from the default: "odom,-points". */
export function layersText(layers) {
  const others = [...layers].filter(([name, on]) => on !== inputOf(name).defaultChecked);
  return others.map(([name, on]) => (on ? name : `-${name}`)).join(",");
}

/** Sets the switches from such a text; all others get their default. */
export function switchLayers(layers, text) {
  const wanted = new Map(text.split(",").map((name) => [name.replace("-", ""), !name.startsWith("-")]));
  for (const [name, on] of layers) {
    const input = inputOf(name);
    if ((wanted.get(name) ?? input.defaultChecked) !== on) input.click();
  }
}

const inputOf = (name) => document.querySelector(`#layers [name="${name}"]`);

function switchOf({ name, label, on, swatch }, changed) {
  const input = element("input", { type: "checkbox", name, checked: on, onchange: () => changed(input.checked) });
  const mark = element("i", { class: `swatch ${swatch[0]}`, style: `--swatch: var(--${swatch[1]})` });
  return element("label", { "data-layer": name }, input, mark, element("span", {}, label));
}

/** Hides switches of layers that the run does not have. */
export function showAvailable(run) {
  const has = {
    truth: !!run.path?.truth,
    points: run.facts.points > 0,
    segments: run.facts.lines > 0,
    keyframes: !!run.map?.keyframes.id?.length,
    covisibility: !!run.map?.edges.shared?.length,
    essential: !!run.map?.keyframes.id?.length,
    loopEdges: !!run.map?.loop_edges.ab?.length,
    surface: !!run.surfaces?.points.grey?.length,
    floor: !!run.surfaces?.grid,
    points2d: run.pictures.length > 0,
    segments2d: run.pictures.length > 0,
  };
  for (const label of document.querySelectorAll("#layers label")) {
    label.hidden = has[label.dataset.layer] === false;
  }
  for (const group of document.querySelectorAll("#layers .group")) group.hidden = !group.querySelector("label:not([hidden])");
  showStrengths(run.map?.edges.shared);
}

/** Sets the range of the covisibility slider from the weakest edge to the strongest. */
function showStrengths(shared) {
  byId("strength-box").hidden = !shared?.length;
  if (!shared?.length) return;
  // Edges are sorted, the strongest first.
  Object.assign(byId("strength"), { min: shared.at(-1), max: shared[0] });
}
