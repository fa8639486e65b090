// SPDX-License-Identifier: BSD-3-Clause
// The map in three dimensions: camera, rendering (only after changes), and its objects.
import { Color, Group, PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { byId } from "./element.js";
import { themeColour } from "./colours.js";
import { diagonalOf, fitView, worthSeeing } from "./framing.js";
import { Landmarks } from "./landmarks.js";
import { Keyframes } from "./keyframes.js";
import { Paths } from "./paths.js";
import { Others } from "./others.js";
import { Correction } from "./correction.js";
import { CameraMark } from "./camera_mark.js";
import { Picker } from "./picker.js";
import { Selection } from "./selection.js";
import { FloorGrid, Surfaces } from "./surfaces.js";

// The map has y down and z forward, the scene y up.
const kUpright = new Quaternion(1, 0, 0, 0);
// Number of landmarks that determine the view.
const kMostLandmarks = 6000;
// Directions towards the eye: obliquely from behind, or from the side if that shows a long map larger.
const kOblique = [[-0.35, 0.75, 0.8], [-0.8, 0.75, 0.35]];
// Seen from above, forward is up in the picture, or, for a long map, to the right.
const kAbove = [[0, 1, 0.001], [0.001, 1, 0]];

export class MapView {
  /** Throws if the browser has no WebGL. */
  constructor(layers, others) {
    this.canvas = byId("map");
    this.layers = layers;
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.scene = new Scene();
    this.world = new Group();
    this.world.quaternion.copy(kUpright);
    this.scene.add(this.world);
    // Objects of the page's own run, which one switch hides.
    this.own = new Group();
    this.world.add(this.own);
    this.camera = new PerspectiveCamera(50, 1, 0.01, 1000);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.addEventListener("change", () => this.invalidate());
    this.parts = {
      surfaces: new Surfaces(this.own),
      floor: new FloorGrid(this.own, () => this.invalidate()),
      landmarks: new Landmarks(this.own),
      keyframes: new Keyframes(this.own),
      paths: new Paths(this.own),
      others: new Others(this.world, others),
      correction: new Correction(this.own),
      mark: new CameraMark(this.own),
      selection: new Selection(this.world),
    };
    this.picker = new Picker(this);
    this.colourMode = "height";
    this.flying = false;
    this.row = 0;
    new ResizeObserver(() => this.resize()).observe(this.canvas.parentElement);
    this.resize();
    this.retheme();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.parts.surfaces.setResolution(width, height);
    this.parts.paths.setResolution(width, height);
    this.parts.correction.setResolution(width, height);
    this.parts.others.setResolution(width, height);
    this.parts.selection.setResolution(width, height);
    if (this.pristine) this.lookAtAll(this.fromAbove);
    this.invalidate();
  }

  retheme() {
    this.scene.background = new Color(themeColour("scene"));
    for (const part of Object.values(this.parts)) part.retheme?.();
    this.invalidate();
  }

  /** Reads the changed parts of the run; the view is kept, except for the first time. */
  setRun(run) {
    const first = !this.run;
    this.run = run;
    const newMap = run.map !== this.map;
    this.map = run.map;
    this.level(run);
    this.seen = worthSeeing(this.inScene(pathOf(run)), this.inScene(landmarksOf(run)));
    this.size = Math.max(1e-3, diagonalOf(this.seen));
    this.camera.near = this.size / 2000;
    this.camera.far = this.size * 40;
    this.camera.updateProjectionMatrix();
    for (const part of Object.values(this.parts)) part.setRun?.(run, this.size);
    // Colours of age reach to the newest frame; the others depend on the map only.
    if (newMap || this.colourMode === "seen") this.parts.landmarks.colour(run, this.colourMode);
    this.applyLayers();
    this.setRow(this.row);
    if (first || this.pristine) this.lookAtAll(this.fromAbove);
  }

  /** Rotates the vertical of the map upright. */
  level(run) {
    const up = run.map?.vertical.up ?? [0, -1, 0];
    const leaning = new Vector3(...up).applyQuaternion(kUpright);
    this.world.quaternion.setFromUnitVectors(leaning.normalize(), new Vector3(0, 1, 0)).multiply(kUpright);
    this.world.updateMatrixWorld(true);
  }

  /** Converts positions of the map to coordinates of the scene. */
  inScene(positions) {
    const p = new Vector3();
    const result = new Float64Array(positions.length);
    for (let i = 0; i + 2 < positions.length; i += 3) {
      p.set(positions[i], positions[i + 1], positions[i + 2]).applyQuaternion(this.world.quaternion).toArray(result, i);
    }
    return result;
  }

  applyLayers() {
    for (const part of Object.values(this.parts)) part.show?.(this.layers);
    this.own.visible = this.layers.get("own") ?? true;
    this.invalidate();
  }

  /** Hides landmarks that were observed over fewer frames. */
  setLeastLife(frames) {
    for (const part of [this.parts.landmarks, this.parts.others]) part.setLeast(frames);
    if (this.run?.map) this.parts.landmarks.colour(this.run, this.colourMode);
    this.setRow(this.row);
  }

  setColourMode(mode) {
    this.colourMode = mode;
    if (this.run) this.parts.landmarks.colour(this.run, mode);
    this.invalidate();
  }

  setRow(row) {
    this.row = row;
    if (!this.run?.rows) return;
    const frame = this.run.frames.id[row];
    const last = row >= this.run.rows - 1;
    // At the end everything is shown, also objects without a known frame.
    for (const part of Object.values(this.parts)) part.setTime?.(this.run, row, last ? Infinity : frame);
    if (this.flying) this.follow(0.35);
    this.invalidate();
  }

  /** Shows the path and the central landmarks, obliquely or from above, from the nearest position that shows all of
   * them. */
  lookAtAll(fromAbove = false) {
    if (!this.seen) return;
    this.fromAbove = fromAbove;
    const tangent = Math.tan((0.5 * this.camera.fov * Math.PI) / 180);
    const fits = (fromAbove ? kAbove : kOblique).map((direction) =>
      ({ direction, ...fitView(this.seen, direction, [0, 1, 0], [tangent * this.camera.aspect, tangent]) }));
    const best = fits[1].distance < 0.85 * fits[0].distance ? fits[1] : fits[0];
    this.controls.target.set(...best.target);
    this.camera.position.copy(this.controls.target).addScaledVector(new Vector3(...best.direction).normalize(), best.distance);
    this.camera.up.set(0, 1, 0);
    this.controls.update();
    this.pristine = true;
    this.invalidate();
  }

  /** Sets the eye and its target, in coordinates of the scene. */
  lookFrom(eye, target) {
    this.camera.position.copy(eye);
    this.controls.target.copy(target);
    this.camera.up.set(0, 1, 0);
    this.controls.update();
    this.pristine = false;
    this.invalidate();
  }

  /** Makes `p` (in the map) the centre of rotation, without moving the eye. */
  focus(p) {
    this.controls.target.set(...this.inScene(p));
    this.controls.update();
    this.pristine = false;
    this.invalidate();
  }

  setFlying(flying) {
    this.flying = flying;
    this.controls.enabled = !flying;
    if (flying) this.follow(1);
  }

  /** Moves the eye towards its position behind and above the camera of the current frame. */
  follow(share) {
    const step = this.parts.keyframes.frustumDepth || this.size / 100;
    const [eye, ahead] = this.parts.mark.behind(this.run, this.row, 6 * step, 2.2 * step, 10 * step);
    this.camera.position.lerp(eye, share);
    this.controls.target.lerp(ahead, share);
    this.camera.lookAt(this.controls.target);
    this.pristine = false;
    this.invalidate();
  }

  invalidate() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.render();
    });
  }

  render() {
    if (this.controls.enabled) this.controls.update();
    this.renderer.render(this.scene, this.camera);
    this.parts.selection.putLabel(this.picker);
  }
}

/** Returns the known positions of the camera. */
function pathOf(run) {
  const path = [];
  const p = [0, 0, 0];
  for (let row = 0; row < run.rows; ++row) {
    run.position(row, p);
    if (p.every(Number.isFinite)) path.push(...p);
  }
  return path;
}

/** Returns some of the points, and the ends of some segments. */
function landmarksOf(run) {
  const all = [run.map?.points.p, run.map?.segments.pq].filter((positions) => positions?.length);
  const step = Math.ceil(all.reduce((sum, positions) => sum + positions.length / 3, 0) / kMostLandmarks);
  return all.flatMap((positions) => Array.from(positions).filter((_, i) => Math.floor(i / 3) % step === 0));
}
