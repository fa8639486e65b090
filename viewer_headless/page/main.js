// SPDX-License-Identifier: BSD-3-Clause
// The page of a run: puts the data in, and wires the parts to each other.
import { Address } from "./address.js";
import { embeddedData, embeddedOthers, Run } from "./data.js";
import { byId, element } from "./element.js";
import { count, metres } from "./format.js";
import { makeColourChoice, showLegend } from "./legend.js";
import { makeLayers, showAvailable } from "./layers.js";
import { follow } from "./live.js";
import { markLoop, showLoops } from "./loops.js";
import { MapView } from "./map_view.js";
import { Picture } from "./picture.js";
import { Plots } from "./plots.js";
import { Replay } from "./replay.js";
import { showProcesses } from "./processes.js";
import { showKicker, showNotes, showSummary, showWarnings } from "./summary.js";
import { makeTheme } from "./theme.js";

const run = new Run();
const others = embeddedOthers();
const layers = makeLayers(others, (name) => (name.endsWith("2d") ? picture.draw() : view?.applyLayers()));
const picture = new Picture(layers);
const plots = new Plots((t_s) => replay.go(run.rowAt(t_s)));
let view = makeView();
const replay = new Replay((row) => {
  view?.setRow(row);
  picture.show(run, row);
  plots.setNow(run.frames.t_s[row]);
});

function makeView() {
  try {
    return new MapView(layers, others.others);
  } catch (error) {
    console.info(`no map: ${error.message}`);
    byId("no-webgl").hidden = false;
    return null;
  }
}

function look(fromAbove) {
  if (byId("fly").getAttribute("aria-pressed") === "true") byId("fly").click();
  view?.lookAtAll(fromAbove);
}

function chooseCorrection() {
  const correction = run.corrections[Number(byId("correction").value)] ?? null;
  view?.parts.correction.choose(correction, Number(byId("blend").value));
  view?.invalidate();
}

function showCorrections() {
  byId("corrections-box").hidden = run.corrections.length === 0;
  const select = byId("correction");
  const chosen = select.value;
  select.replaceChildren(...run.corrections.map((c, i) =>
    element("option", { value: i }, `at frame ${c.frame}: up to ${metres(c.moved_m)}`)));
  const largest = run.corrections.reduce((best, c, i, all) => (c.moved_m > (all[best]?.moved_m ?? -1) ? i : best), 0);
  select.value = chosen !== "" && chosen < run.corrections.length ? chosen : largest;
  chooseCorrection();
}

function chooseLoop(loop, index) {
  markLoop(index);
  replay.go(run.rowOf(loop.frame));
  const at = run.corrections.findIndex((c) => c.moved_m === loop.moved_m);
  if (at >= 0) {
    byId("correction").value = at;
    byId("blend").value = 0;
    chooseCorrection();
  }
  byId("stage").scrollIntoView({ behavior: "smooth" });
}

/** The covisibility of which two keyframes share at least as many landmarks as the slider says. */
function chooseStrength() {
  const least = Number(byId("strength").value);
  const edges = view?.parts.keyframes.setStrength(least) ?? 0;
  byId("strength-text").textContent = `${least} landmarks: ${count(edges)} edges`;
  view?.setRow(replay.row);
}

/** A click that is no drag shows what stands there and who observes it; with the shift key, how far that is from what was
 * clicked before. */
function makePicking() {
  const canvas = byId("map");
  let down = null;
  const choose = (picked) => {
    view.parts.selection.choose(run, picked);
    view.invalidate();
  };
  view.parts.selection.goTo = (frame) => replay.go(run.rowOf(frame));
  view.parts.selection.changed = () => view.invalidate();
  canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
  canvas.addEventListener("click", (event) => {
    if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
    const picked = view.picker.pick(event.offsetX, event.offsetY);
    if (!event.shiftKey || !view.parts.selection.picked) return choose(picked);
    view.parts.selection.measureTo(run, picked);
    view.invalidate();
  });
  document.addEventListener("keydown", (event) => event.key === "Escape" && choose(null));
}

/** 1, 2 and 3 choose what the map is looked at from, R the right image. */
function makeKeys() {
  const buttons = { 1: "view-all", 2: "view-top", 3: "fly", r: "right-image" };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select, textarea")) return;
    const button = buttons[event.key.toLowerCase()];
    if (button && !byId(button).hidden) byId(button).click();
  });
  // After a click the keys are for the replay again, not for what was clicked.
  document.addEventListener("click", (event) => event.detail > 0 && event.target.closest("button, label, [type=checkbox]") && document.activeElement.blur());
}

function update(changed, state) {
  showSummary(run);
  showWarnings(run);
  showKicker(run, state);
  showNotes(run);
  showAvailable(run);
  showProcesses(run);
  if (changed.has("frames") || changed.has("map")) view?.setRun(run);
  if (changed.has("map")) {
    showLoops(run, chooseLoop);
    showCorrections();
    chooseStrength();
  }
  replay.setRun(run);
  if (changed.has("pictures")) picture.show(run, replay.row);
  plots.setRun(run);
  showLegend(view?.colourMode, view?.parts.landmarks.range);
}

makeColourChoice((mode) => {
  view?.setColourMode(mode);
  showLegend(mode, view?.parts.landmarks.range);
});
makeTheme(() => {
  view?.retheme();
  plots.redraw();
});
byId("correction").addEventListener("change", chooseCorrection);
byId("blend").addEventListener("input", chooseCorrection);
byId("strength").addEventListener("input", () => {
  const shown = document.querySelector("[name=covisibility]");
  if (!shown.checked) shown.click();
  chooseStrength();
});
byId("view-all").addEventListener("click", () => look(false));
byId("view-top").addEventListener("click", () => look(true));
byId("fly").addEventListener("click", () => {
  const flying = byId("fly").getAttribute("aria-pressed") !== "true";
  byId("fly").setAttribute("aria-pressed", flying);
  view?.setFlying(flying);
  if (flying && !replay.playing) replay.play();
});
if (view) makePicking();
makeKeys();
const address = new Address(view, replay);
view?.controls.addEventListener("end", () => address.write());
for (const id of ["time", "play", "view-all", "view-top", "fly"]) {
  for (const event of ["change", "click"]) byId(id).addEventListener(event, () => address.write());
}
new ResizeObserver(() => picture.draw()).observe(byId("picture"));
byId("map").addEventListener("pointerdown", () => view && (view.pristine = false));
byId("map").addEventListener("wheel", () => view && (view.pristine = false), { passive: true });

const data = embeddedData();
if (data) {
  update(run.take(data), null);
  address.read();
} else {
  let state = "live";
  follow(run, (changed) => update(changed, state), (now) => {
    state = now;
    showKicker(run, now);
  });
}
// For tests and for the curious.
window.plslam = { run, view, replay, plots, picture };
