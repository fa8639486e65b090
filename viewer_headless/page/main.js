// SPDX-License-Identifier: BSD-3-Clause
// The page of a run: reads the data and connects the parts.
import { Address, choiceEntry, frameEntry, viewEntry } from "./address.js";
import { embeddedData, embeddedOthers, Run } from "./data.js";
import { byId, element } from "./element.js";
import { count, metres, quantiles } from "./format.js";
import { makeHelp } from "./help.js";
import { makeColourChoice, showLegend } from "./legend.js";
import { layersText, makeLayers, showAvailable, switchLayers } from "./layers.js";
import { follow } from "./live.js";
import { markLoop, showLoops } from "./loops.js";
import { MapView } from "./map_view.js";
import { makeOrders, showOrders } from "./orders.js";
import { Picture } from "./picture.js";
import { Plots } from "./plots.js";
import { embeddedRefinement, showRefinement } from "./refinement.js";
import { Replay } from "./replay.js";
import { showProcesses } from "./processes.js";
import { showKicker, showNotes, showRuns, showSummary, showWarnings } from "./summary.js";
import { makeTheme } from "./theme.js";

// The value written by the viewer.
const kLongestLife = 65535;
// Delay after the last movement of the pointer.
const kRest_ms = 40;

const run = new Run();
const others = embeddedOthers();
const layers = makeLayers(others, (name) => {
  if (name.endsWith("2d")) picture.draw();
  else view?.applyLayers();
  address.write();
});
const picture = new Picture(layers, () => address.write());
const plots = new Plots((t_s) => replay.go(run.rowAt(t_s)));
let view = makeView();
const replay = new Replay((row) => {
  view?.setRow(row);
  picture.show(run, row);
  plots.setNow(run.frames.t_s[row]);
  address.write();
});
/** A selection in the address, until it exists or something else is selected. */
let wanted = null;
const chooseColour = makeColourChoice((mode) => {
  view?.setColourMode(mode);
  showLegend(mode, view?.parts.landmarks.range);
  address.write();
});
const address = new Address([
  frameEntry(replay),
  choiceEntry("picture", "left", () => picture.wanted, (name) => picture.choose(name)),
  choiceEntry("layers", "", () => layersText(layers), (text) => switchLayers(layers, text)),
  ...(view ? [viewEntry(view), ...mapEntries()] : []),
]);

function makeView() {
  try {
    return new MapView(layers, others.others);
  } catch (error) {
    // Everything else works without the map.
    if (new OffscreenCanvas(1, 1).getContext("webgl2")) {
      console.error(error);
      byId("no-map").textContent = `The map cannot be drawn: ${error.message}. Everything else works.`;
    }
    byId("no-map").hidden = false;
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

/** Shows the covisibility of keyframes that share at least as many landmarks as the slider states. */
function chooseStrength() {
  const least = Number(byId("strength").value);
  const edges = view?.parts.keyframes.setStrength(least) ?? 0;
  byId("strength-text").textContent = `${least} landmarks: ${count(edges)} edges`;
  view?.setRow(replay.row);
}

/** Hides landmarks that were observed over fewer frames than the slider states. */
function chooseLife() {
  const least = Number(byId("life").value);
  byId("life-text").textContent = `${count(least)} frames`;
  view?.setLeastLife(least);
  address.write();
}

/** The end of the slider is the 99 % quantile of the points. */
function showLives() {
  const lives = run.map.points.life ?? [];
  byId("life-box").hidden = !lives.length;
  byId("life").max = Math.max(1, Number(byId("life").value), quantiles(lives, 0, 0.99)[1]);
  byId("life-text").textContent = `${count(Number(byId("life").value))} frames`;
}

function mapEntries() {
  const { selection } = view.parts;
  return [
    choiceEntry("colour", "height", () => view.colourMode, (mode) => chooseColour(mode)),
    choiceEntry("least", "0", () => byId("life").value, (least) => {
      // The slider of a continuing run may not reach that far yet.
      if (!run.facts.finished) byId("life").max = Math.max(Number(byId("life").max), Math.min(kLongestLife, Number(least) || 0));
      byId("life").value = Number(least) || 0;
      chooseLife();
    }),
    {
      read: (parameters) => {
        const pick = parameters.get("pick");
        wanted = { pick, to: pick && parameters.get("to") };
        chooseWanted();
      },
      write: (parameters) => {
        const [pick, to] = wanted?.pick ? [wanted.pick, wanted.to]
          : [selection.textOf(selection.picked, selection.id), selection.textOf(selection.other, selection.otherId)];
        if (pick) parameters.set("pick", pick);
        if (pick && to) parameters.set("to", to);
      },
    },
  ];
}

/** Selects the object in the address if the map has it. Otherwise the request is kept while the run continues. */
function chooseWanted() {
  if (!wanted || !view) return;
  const { selection } = view.parts;
  const [picked, other] = [selection.parse(run, wanted.pick), selection.parse(run, wanted.to)];
  const hasAll = (picked || !wanted.pick) && (other || !wanted.to);
  if (hasAll || run.facts.finished) wanted = null;
  selection.choose(run, picked);
  if (picked && other) selection.measureTo(run, other);
}

/** A click without a drag selects the object there and shows its observations; with the shift key, its distance from
 * the previous selection. A double click makes it the centre of rotation. */
function makePicking() {
  const canvas = byId("map");
  const { selection } = view.parts;
  let down = null;
  selection.goTo = (frame) => replay.go(run.rowOf(frame));
  selection.close = chooseNothing;
  selection.changed = () => {
    view.invalidate();
    address.write();
  };
  canvas.addEventListener("pointerdown", (event) => {
    down = [event.clientX, event.clientY];
    canvas.style.cursor = "";
  });
  canvas.addEventListener("click", (event) => {
    if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
    wanted = null;
    const picked = view.picker.pick(event.offsetX, event.offsetY);
    if (event.shiftKey && selection.picked) selection.measureTo(run, picked);
    else selection.choose(run, picked);
  });
  canvas.addEventListener("dblclick", (event) => {
    const picked = view.picker.pick(event.offsetX, event.offsetY);
    if (!picked || view.flying) return;
    view.focus(selection.placeOf(run, picked));
  });
  // Only when the pointer rests, because all landmarks are tested.
  let rest;
  canvas.addEventListener("pointermove", (event) => {
    clearTimeout(rest);
    if (event.buttons) return;
    rest = setTimeout(() => (canvas.style.cursor = view.picker.pick(event.offsetX, event.offsetY) ? "pointer" : ""), kRest_ms);
  });
}

/** Closes the part opened last: the help (by itself), the large picture, the box of the selection. */
function close() {
  if (byId("help").open) return byId("help").close();
  if (picture.isLarge) return picture.enlarge(false);
  chooseNothing();
}

function chooseNothing() {
  wanted = null;
  view?.parts.selection.choose(run, null);
}

/** The keys listed in help.js; the replay handles its own ones. */
function makeKeys() {
  const buttons = { 1: "view-all", 2: "view-top", 3: "fly", r: "right-image", d: "disparity", "?": "help-button" };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select, textarea, #order")) return;
    // A key that is held down acts once.
    if (event.repeat) return;
    if (event.key === "Escape") return close();
    if (byId("help").open && event.key !== "?") return;
    if (event.key.toLowerCase() === "f") picture.enlarge(!picture.isLarge);
    const button = buttons[event.key.toLowerCase()];
    if (button && !byId(button).hidden) byId(button).click();
  });
  // After a click the keys are for the replay again, not for the clicked element.
  document.addEventListener("click", (event) => event.detail > 0 && event.target.closest("button, label, [type=checkbox]") && document.activeElement.blur());
}

function update(changed, state) {
  showSummary(run);
  if (run.others?.length) showRuns([run, ...run.others].map((r, i) => ({ name: r.label, colour: i ? `other${i - 1}` : "path", run: r })));
  showWarnings(run);
  showKicker(run, state);
  showNotes(run);
  showAvailable(run);
  showProcesses(run);
  if (["frames", "map", "surfaces"].some((part) => changed.has(part))) view?.setRun(run);
  if (changed.has("map")) {
    showLoops(run, chooseLoop);
    showCorrections();
    chooseStrength();
    showLives();
  }
  replay.setRun(run);
  picture.show(run, replay.row);
  plots.setRun(run);
  showLegend(view?.colourMode, view?.parts.landmarks.range);
}

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
byId("life").addEventListener("input", chooseLife);
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
makeHelp();
// Also while a rotation is damped.
view?.controls.addEventListener("change", () => address.write());
new ResizeObserver(() => picture.draw()).observe(byId("picture"));
byId("map").addEventListener("pointerdown", () => view && (view.pristine = false));
byId("map").addEventListener("wheel", () => view && (view.pristine = false), { passive: true });

if (others.others.length && view) {
  run.label = others.name;
  run.others = view.parts.others.runs.map((other) => other.run);
}
Object.assign(byId("comparison"), { hidden: !others.comparison, href: others.comparison || "#" });

/** Reads the address once there are data. */
function updateAndRead(changed, state) {
  update(changed, state);
  if (run.rows && !address.wasRead) address.read();
  else if (changed.has("map")) chooseWanted();
}

showRefinement(embeddedRefinement());
const data = embeddedData();
if (data) {
  updateAndRead(run.take(data), null);
} else {
  let state = "live";
  makeOrders();
  follow(run, (changed) => updateAndRead(changed, state), (now) => {
    state = now;
    showOrders(now);
    showKicker(run, now);
  });
}
// For tests and for the console of the browser.
window.plslam = { run, view, replay, plots, picture, address };
