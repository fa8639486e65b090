// SPDX-License-Identifier: BSD-3-Clause
// The current frame with its tracked features, drawn sharp over the small picture: the left image, or on request the
// right one or the disparities of the pair.
import { byId, element } from "./element.js";
import { css, cssGradient, ramp, scales } from "./colours.js";
import { countUpTo } from "./data.js";
import { matchBlocks } from "./disparity.js";
import { count, metres, states } from "./format.js";

const kOldAge = 20;
const kNearDisparity = 64;
const kNoDisparity = 65535;
const kTicks = [0.25, 0.5, 0.75, 1];

/** Converts a disparity in pixels of the camera to a share of the scale from far to near. */
const nearness = (disparity_px) => Math.log2(1 + disparity_px) / Math.log2(1 + kNearDisparity);
/** The inverse. */
const disparityAt = (share) => (1 + kNearDisparity) ** share - 1;

function pointColour(disparity) {
  if (disparity === kNoDisparity) return "rgb(190 190 190 / 0.8)";
  return css(ramp(scales.near, nearness(disparity / 32)));
}

/** `shift`: pixels of the picture for each pixel of disparity: 0 in the left image; the right one shows only
 * features with depth. */
function drawSegments(context, { segments, segment_ages, segment_disparities }, scale, mark, shift, byDepth) {
  for (let i = 0; i < segment_ages.length; ++i) {
    const [u0, v0, u1, v1] = segments.subarray(4 * i, 4 * i + 4);
    const [d0, d1] = segment_disparities.subarray(2 * i, 2 * i + 2);
    const deep = d0 !== kNoDisparity;
    if (shift && !deep) continue;
    context.strokeStyle = !deep ? "rgb(200 200 200 / 0.7)" : byDepth ? pointColour(0.5 * (d0 + d1)) : css(ramp(scales.observations, segment_ages[i] / kOldAge));
    context.lineWidth = (deep ? 2.5 : 1) * mark;
    context.setLineDash(deep ? [] : [4, 4]);
    context.beginPath();
    context.moveTo(((u0 - shift * d0) / 32) * scale, (v0 / 32) * scale);
    context.lineTo(((u1 - shift * d1) / 32) * scale, (v1 / 32) * scale);
    context.stroke();
  }
  context.setLineDash([]);
}

function drawPoints(context, { points, point_ages }, scale, mark, shift) {
  context.lineWidth = 1.5 * mark;
  for (let i = 0; i < point_ages.length; ++i) {
    const [u, v, disparity] = points.subarray(3 * i, 3 * i + 3);
    if (shift && disparity === kNoDisparity) continue;
    context.strokeStyle = pointColour(disparity);
    context.beginPath();
    context.arc(((u - shift * disparity) / 32) * scale, (v / 32) * scale, (point_ages[i] ? 3.5 : 2) * mark, 0, 2 * Math.PI);
    context.stroke();
  }
}

async function decoded(jpeg) {
  const image = new Image();
  image.src = `data:image/jpeg;base64,${jpeg}`;
  await image.decode();
  return image;
}

function greyOf(image, width, height) {
  // Without this hint the pixels are read back from the graphics card, which may take seconds.
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0, width, height);
  const { data } = context.getImageData(0, 0, width, height);
  return Uint8Array.from({ length: width * height }, (_, i) => data[4 * i]);
}

/** Matches the pair at the size of the right image, which is the smaller one: {width, height, disparities}, in pixels of the
 * camera, which is `camera_width_px` wide. */
export function disparitiesOf(left, right, camera_width_px) {
  const [width, height] = [right.naturalWidth, right.naturalHeight];
  const shrink = width / camera_width_px;
  const most = Math.min(width >> 1, Math.ceil(1.25 * kNearDisparity * shrink) + 2);
  const disparities = matchBlocks(greyOf(left, width, height), greyOf(right, width, height), width, height, most);
  return { width, height, disparities: disparities.map((d) => d / shrink) };
}

/** Pixels without a disparity are transparent. */
function coloured({ width, height, disparities }) {
  const canvas = new OffscreenCanvas(width, height);
  const pixels = new ImageData(width, height);
  disparities.forEach((d, i) => Number.isFinite(d) && pixels.data.set([...ramp(scales.near, nearness(d)).map((c) => 255 * c), 255], 4 * i));
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  return canvas;
}

export class Picture {
  /** `changed()` is called when another image is chosen. */
  constructor(layers, changed) {
    this.canvas = byId("frame");
    this.layers = layers;
    this.image = new Image();
    // Resolves when the picture requested last has been drawn.
    this.loaded = Promise.resolve();
    this.shown = null;
    this.changed = changed;
    /** "left", "right" or "disparity". */
    this.wanted = "left";
    this.buttons = { right: byId("right-image"), disparity: byId("disparity") };
    for (const [name, button] of Object.entries(this.buttons)) {
      button.addEventListener("click", () => this.choose(this.wanted === name ? "left" : name));
    }
    this.canvas.addEventListener("click", () => this.enlarge(!this.isLarge));
  }

  choose(name) {
    this.wanted = Object.hasOwn(this.buttons, name) ? name : "left";
    for (const [of, button] of Object.entries(this.buttons)) button.setAttribute("aria-pressed", of === this.wanted);
    this.load();
    this.changed();
  }

  get isLarge() {
    return byId("picture").classList.contains("large");
  }

  enlarge(large) {
    byId("picture").classList.toggle("large", large && !!this.shown);
    this.draw();
  }

  /** If the frame has no right image (RGB-D), the left one is shown. */
  get kind() {
    return this.shown?.right_jpeg ? this.wanted : "left";
  }

  show(run, row) {
    if (!run.rows) return;
    const frame = run.frames.id[row];
    const picture = this.find(run, frame);
    byId("picture").classList.toggle("none", !picture);
    const f = run.frames;
    byId("frame-caption").textContent = [
      `frame ${frame}`,
      states[f.state[row]],
      `${count(f.tracked_points[row])} points`,
      `${count(f.tracked_lines[row])} lines tracked`,
      f.keyframe[row] ? "keyframe" : null,
      picture && picture.frame !== frame ? `picture of frame ${picture.frame}` : null,
    ].filter(Boolean).join(" · ");
    // On a live page a picture may arrive before the camera is known.
    const { camera } = run.facts;
    if (picture && (picture !== this.shown || camera?.width_px !== this.camera?.width_px)) {
      this.shown = picture;
      this.camera = camera;
      // Pixels of the small picture per pixel of the camera, the unit of disparities.
      this.shrink = picture.width_px / (camera?.width_px ?? picture.width_px);
      this.load();
    }
  }

  load() {
    if (!this.shown) return;
    const { shown, kind } = this;
    for (const button of Object.values(this.buttons)) button.hidden = !shown.right_jpeg;
    const wanted = (this.asked = {});
    const images = { left: [shown.jpeg], right: [shown.right_jpeg], disparity: [shown.jpeg, shown.right_jpeg] }[kind];
    this.loaded = Promise.all(images.map(decoded)).then(([image, right]) => {
      if (this.asked !== wanted) return;
      this.image = image;
      this.matched = right ? disparitiesOf(image, right, this.camera?.width_px ?? shown.width_px) : null;
      this.overlay = this.matched && coloured(this.matched);
      this.showLegend();
      this.draw();
    });
  }

  /** Legend of the colours of disparities in metres. */
  showLegend() {
    const legend = byId("disparity-legend");
    legend.hidden = !this.matched;
    if (!this.matched) return;
    const { f_px, baseline_m } = this.camera ?? {};
    const depth = (share) => (f_px ? metres((f_px * baseline_m) / disparityAt(share)) : `${disparityAt(share).toFixed(0)} px`);
    legend.replaceChildren(element("i", { style: `background: ${cssGradient(scales.near)}` }),
      element("span", { class: "ends" }, element("b", {}, "far"), ...kTicks.map((share) => element("b", {}, depth(share)))));
  }

  find(run, frame) {
    const frames = run.pictures.map((p) => p.frame);
    const at = countUpTo(frames, frame) - 1;
    return run.pictures[Math.max(0, at)] ?? null;
  }

  draw() {
    const picture = this.shown;
    if (!picture) return;
    this.canvas.style.setProperty("--aspect", picture.width_px / picture.height_px);
    const width = this.canvas.clientWidth || picture.width_px;
    const density = Math.min(3, window.devicePixelRatio || 1);
    const scale = width / picture.width_px;
    this.canvas.style.aspectRatio = `${picture.width_px} / ${picture.height_px}`;
    this.canvas.width = Math.round(width * density);
    this.canvas.height = Math.round(picture.height_px * scale * density);
    const context = this.canvas.getContext("2d");
    context.scale(density, density);
    context.drawImage(this.image, 0, 0, width, picture.height_px * scale);
    if (this.overlay) context.drawImage(this.overlay, 0, 0, width, picture.height_px * scale);
    // Size of marks that fits the shown picture.
    const mark = Math.min(1.3, Math.max(0.55, Math.sqrt(picture.height_px * scale * width) / 480));
    const shift = this.kind === "right" ? this.shrink : 0;
    if (this.layers.get("segments2d")) drawSegments(context, picture.features, scale, mark, shift, !!this.overlay);
    if (this.layers.get("points2d")) drawPoints(context, picture.features, scale, mark, shift);
  }
}
