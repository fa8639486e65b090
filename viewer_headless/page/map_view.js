// The map in three dimensions: camera, light-footed rendering (only when something has changed), and what stands in it.
import { Box3, Color, Group, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { byId } from "./element.js";
import { themeColour } from "./colours.js";
import { quantiles } from "./format.js";
import { Landmarks } from "./landmarks.js";
import { Keyframes } from "./keyframes.js";
import { Paths } from "./paths.js";
import { Correction } from "./correction.js";
import { CameraMark } from "./camera_mark.js";

export class MapView {
  /** Throws where the browser has no WebGL. */
  constructor(layers) {
    this.canvas = byId("map");
    this.layers = layers;
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.scene = new Scene();
    // The map has y down and z forward.
    this.world = new Group();
    this.world.rotation.x = Math.PI;
    this.scene.add(this.world);
    this.camera = new PerspectiveCamera(50, 1, 0.01, 1000);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.addEventListener("change", () => this.invalidate());
    this.parts = {
      landmarks: new Landmarks(this.world),
      keyframes: new Keyframes(this.world),
      paths: new Paths(this.world),
      correction: new Correction(this.world),
      mark: new CameraMark(this.world),
    };
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
    this.parts.paths.setResolution(width, height);
    this.parts.correction.setResolution(width, height);
    if (this.pristine) this.lookAtAll(this.fromAbove);
    this.invalidate();
  }

  retheme() {
    this.scene.background = new Color(themeColour("scene"));
    for (const part of Object.values(this.parts)) part.retheme?.();
    this.invalidate();
  }

  /** Takes in what has changed of the run; the view stays where it is but for the first time. */
  setRun(run) {
    const first = !this.run;
    this.run = run;
    const newMap = run.map !== this.map;
    this.map = run.map;
    if (newMap) this.landmarkBounds = boundsOf(run.map);
    this.box = boxOf(run, this.landmarkBounds);
    this.size = Math.max(1e-3, this.box.getSize(new Vector3()).length());
    this.camera.near = this.size / 2000;
    this.camera.far = this.size * 40;
    this.camera.updateProjectionMatrix();
    for (const part of Object.values(this.parts)) part.setRun?.(run, this.size);
    // Colours of age reach to the newest frame; the others are the map's alone.
    if (newMap || this.colourMode === "seen") this.parts.landmarks.colour(run, this.colourMode);
    this.applyLayers();
    this.setRow(this.row);
    if (first || this.pristine) this.lookAtAll(this.fromAbove);
  }

  applyLayers() {
    for (const part of Object.values(this.parts)) part.show?.(this.layers);
    this.invalidate();
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
    // At the end all is shown, also what no frame is known for.
    for (const part of Object.values(this.parts)) part.setTime?.(this.run, row, last ? Infinity : frame);
    if (this.flying) this.follow(0.35);
    this.invalidate();
  }

  /** Looks at everything obliquely from behind, or from above. */
  lookAtAll(fromAbove = false) {
    this.fromAbove = fromAbove;
    const centre = this.box.getCenter(new Vector3());
    const distance = (0.5 * this.size) / Math.tan((0.5 * this.camera.fov * Math.PI) / 180) / Math.min(1, this.camera.aspect);
    const direction = fromAbove ? new Vector3(0, 1, 0.001) : new Vector3(-0.35, 0.75, 0.8);
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(direction.normalize(), distance);
    this.camera.up.set(0, 1, 0);
    this.controls.update();
    this.pristine = true;
    this.invalidate();
  }

  setFlying(flying) {
    this.flying = flying;
    this.controls.enabled = !flying;
    if (flying) this.follow(1);
  }

  /** Moves the eye towards its place behind and above the camera of the moment. */
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
  }
}

/** Where most of the points lie, as [low, high] of each axis of the map; null without points. */
function boundsOf(map) {
  const points = map?.points.p;
  if (!points?.length) return null;
  return [0, 1, 2].map((axis) => quantiles(points.filter((_, i) => i % 3 === axis), 0.1, 0.9));
}

/** What is worth looking at: the path and most of the points, in the scene's coordinates (y up). */
function boxOf(run, bounds) {
  const box = new Box3();
  const p = [0, 0, 0];
  for (let row = 0; row < run.rows; ++row) {
    run.position(row, p);
    if (p.every(Number.isFinite)) box.expandByPoint(new Vector3(p[0], -p[1], -p[2]));
  }
  if (box.isEmpty()) box.set(new Vector3(-1, -1, -1), new Vector3(1, 1, 1));
  if (bounds) {
    const middle = box.getCenter(new Vector3());
    const reach = 3 * Math.max(1, box.getSize(new Vector3()).length());
    // A few far points must not make the path a dot.
    const near = (value, centre) => Math.min(centre + reach, Math.max(centre - reach, value));
    for (const k of [0, 1]) {
      box.expandByPoint(new Vector3(near(bounds[0][k], middle.x), near(-bounds[1][k], middle.y), near(-bounds[2][k], middle.z)));
    }
  }
  return box;
}
