// SPDX-License-Identifier: BSD-3-Clause
// The frame of the moment with what was tracked in it, drawn sharp over the small picture: the left image, or the right one when
// asked for.
import { byId } from "./element.js";
import { css, ramp, scales } from "./colours.js";
import { countUpTo } from "./data.js";
import { count, states } from "./format.js";

const kOldAge = 20;
const kNearDisparity = 64;
const kNoDisparity = 65535;

function pointColour(disparity) {
  if (disparity === kNoDisparity) return "rgb(190 190 190 / 0.8)";
  return css(ramp(scales.near, Math.log2(1 + disparity / 32) / Math.log2(1 + kNearDisparity)));
}

function drawSegments(context, { segments, segment_ages, segment_depths }, scale, mark) {
  for (let i = 0; i < segment_ages.length; ++i) {
    const [u0, v0, u1, v1] = segments.subarray(4 * i, 4 * i + 4);
    const deep = segment_depths[i];
    context.strokeStyle = deep ? css(ramp(scales.observations, segment_ages[i] / kOldAge)) : "rgb(200 200 200 / 0.7)";
    context.lineWidth = (deep ? 2.5 : 1) * mark;
    context.setLineDash(deep ? [] : [4, 4]);
    context.beginPath();
    context.moveTo((u0 / 32) * scale, (v0 / 32) * scale);
    context.lineTo((u1 / 32) * scale, (v1 / 32) * scale);
    context.stroke();
  }
  context.setLineDash([]);
}

/** `shift`: pixels of the picture for each pixel of disparity: 0 in the left image; the right one has points with depth alone. */
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

export class Picture {
  constructor(layers) {
    this.canvas = byId("frame");
    this.layers = layers;
    this.image = new Image();
    // Settled when the picture asked for last has been drawn.
    this.loaded = Promise.resolve();
    this.shown = null;
    this.button = byId("right-image");
    this.button.addEventListener("click", () => {
      this.button.setAttribute("aria-pressed", !this.wantsRight);
      this.load();
    });
  }

  get wantsRight() {
    return this.button.getAttribute("aria-pressed") === "true";
  }

  /** Where the frame has no right image (RGB-D), the left one is shown. */
  get isRight() {
    return this.wantsRight && !!this.shown?.right_jpeg;
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
    if (picture && picture !== this.shown) {
      this.shown = picture;
      // Pixels of the small picture for each of the camera, in which disparities are.
      this.shrink = picture.width_px / (run.facts.camera?.width_px ?? picture.width_px);
      this.load();
    }
  }

  load() {
    if (!this.shown) return;
    this.button.hidden = !this.shown.right_jpeg;
    const image = new Image();
    image.src = `data:image/jpeg;base64,${this.isRight ? this.shown.right_jpeg : this.shown.jpeg}`;
    this.asked = image;
    this.loaded = image.decode().then(() => {
      if (this.asked !== image) return;
      this.image = image;
      this.draw();
    });
  }

  find(run, frame) {
    const frames = run.pictures.map((p) => p.frame);
    const at = countUpTo(frames, frame) - 1;
    return run.pictures[Math.max(0, at)] ?? null;
  }

  draw() {
    const picture = this.shown;
    if (!picture) return;
    const width = this.canvas.clientWidth || picture.width_px;
    const density = Math.min(3, window.devicePixelRatio || 1);
    const scale = width / picture.width_px;
    this.canvas.style.aspectRatio = `${picture.width_px} / ${picture.height_px}`;
    this.canvas.width = Math.round(width * density);
    this.canvas.height = Math.round(picture.height_px * scale * density);
    const context = this.canvas.getContext("2d");
    context.scale(density, density);
    context.drawImage(this.image, 0, 0, width, picture.height_px * scale);
    // Marks that fit the picture as it is shown.
    const mark = Math.min(1.3, Math.max(0.55, Math.sqrt(picture.height_px * scale * width) / 480));
    if (this.layers.get("segments2d") && !this.isRight) drawSegments(context, picture.features, scale, mark);
    if (this.layers.get("points2d")) drawPoints(context, picture.features, scale, mark, this.isRight ? this.shrink : 0);
  }
}
