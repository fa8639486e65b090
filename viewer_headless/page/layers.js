// Switches of what is drawn.
import { byId, element } from "./element.js";

export const kLayers = [
  { name: "points", label: "Points", on: true },
  { name: "segments", label: "Segments", on: true },
  { name: "keyframes", label: "Keyframes", on: true },
  { name: "covisibility", label: "Covisibility", on: false },
  { name: "essential", label: "Essential graph", on: false },
  { name: "loopEdges", label: "Loops", on: true, swatch: "loop" },
  { name: "path", label: "Estimated path", on: true, swatch: "path" },
  { name: "truth", label: "True path", on: true, swatch: "truth" },
  { name: "live", label: "As published", on: false, swatch: "live" },
  { name: "odom", label: "Odometry alone", on: false, swatch: "odom" },
  { name: "points2d", label: "Points in picture", on: true },
  { name: "segments2d", label: "Segments in picture", on: true },
];

/** A map of name to boolean; `changed(name)` is called after a switch. */
export function makeLayers(changed) {
  const layers = new Map(kLayers.map((layer) => [layer.name, layer.on]));
  const box = byId("layers");
  for (const { name, label, on, swatch } of kLayers) {
    const input = element("input", {
      type: "checkbox",
      name,
      checked: on,
      onchange: () => {
        layers.set(name, input.checked);
        changed(name);
      },
    });
    const mark = swatch ? element("i", { class: "swatch", style: `--swatch: var(--${swatch})` }) : null;
    box.append(element("label", { "data-layer": name }, input, element("span", {}, label), mark));
  }
  return layers;
}

/** Hides switches of what the run has not. */
export function showAvailable(run) {
  const has = {
    truth: !!run.path?.truth,
    points: run.facts.points > 0,
    segments: run.facts.lines > 0,
    keyframes: !!run.map?.keyframes.id?.length,
    covisibility: !!run.map?.edges.shared?.length,
    essential: !!run.map?.keyframes.id?.length,
    loopEdges: !!run.map?.loop_edges.ab?.length,
    points2d: run.pictures.length > 0,
    segments2d: run.pictures.length > 0,
  };
  for (const label of document.querySelectorAll("#layers label")) {
    label.hidden = has[label.dataset.layer] === false;
  }
}
