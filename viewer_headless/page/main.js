// The page of a run: puts the data in, and wires the parts to each other.
import { embeddedData, Run } from "./data.js";
import { byId, element } from "./element.js";
import { metres } from "./format.js";
import { makeColourChoice, showLegend } from "./legend.js";
import { makeLayers, showAvailable } from "./layers.js";
import { follow } from "./live.js";
import { markLoop, showLoops } from "./loops.js";
import { MapView } from "./map_view.js";
import { Picture } from "./picture.js";
import { Plots } from "./plots.js";
import { Replay } from "./replay.js";
import { showKicker, showNotes, showSummary, showWarnings } from "./summary.js";
import { makeTheme } from "./theme.js";

const run = new Run();
const layers = makeLayers((name) => (name.endsWith("2d") ? picture.draw() : view?.applyLayers()));
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
    return new MapView(layers);
  } catch (error) {
    console.info(`no map: ${error.message}`);
    byId("no-webgl").hidden = false;
    return null;
  }
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

function update(changed, state) {
  showSummary(run);
  showWarnings(run);
  showKicker(run, state);
  showNotes(run);
  showAvailable(run);
  if (changed.has("frames") || changed.has("map")) view?.setRun(run);
  if (changed.has("map")) {
    showLoops(run, chooseLoop);
    showCorrections();
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
byId("view-all").addEventListener("click", () => view?.lookAtAll());
byId("view-top").addEventListener("click", () => view?.lookAtAll(true));
byId("fly").addEventListener("click", () => {
  const flying = byId("fly").getAttribute("aria-pressed") !== "true";
  byId("fly").setAttribute("aria-pressed", flying);
  view?.setFlying(flying);
  if (flying && !replay.playing) replay.play();
});
new ResizeObserver(() => picture.draw()).observe(byId("picture"));
byId("map").addEventListener("pointerdown", () => view && (view.pristine = false));
byId("map").addEventListener("wheel", () => view && (view.pristine = false), { passive: true });

const data = embeddedData();
if (data) {
  update(run.take(data), null);
} else {
  let state = "live";
  follow(run, (changed) => update(changed, state), (now) => {
    state = now;
    showKicker(run, now);
  });
}
// For tests and for the curious.
window.plslam = { run, view, replay, plots };
