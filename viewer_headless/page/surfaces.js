// SPDX-License-Identifier: BSD-3-Clause
// Surfaces of dense_process under the landmarks: their points, and the grid of the floor.
import { BufferAttribute, BufferGeometry, CanvasTexture, DoubleSide, Group, Mesh, MeshBasicMaterial, NearestFilter, PlaneGeometry, Points, ShaderMaterial } from "three";
import { themeColour } from "./colours.js";

// Behind this many points' distances, surfaces hide landmarks: their own ones are in front of them.
const kBehind = 2.5;
// Side of the square of a point, in distances of neighbouring points.
const kSquare = 1.7;

// A surface that is seen from behind is not drawn: from outside, one looks into a room.
const kVertex = `
  attribute vec3 facing;
  attribute float grey;
  varying float vGrey;
  uniform float side;
  uniform float focal_px;
  uniform float behind;
  void main() {
    vec4 p = modelViewMatrix * vec4(position, 1.0);
    vec3 n = normalize(normalMatrix * (facing - 128.0 / 255.0));
    float cosine = dot(n, -normalize(p.xyz));
    if (cosine < 0.02) {
      gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
      return;
    }
    vGrey = grey * (0.7 + 0.3 * cosine);
    gl_Position = projectionMatrix * p;
    vec4 back = projectionMatrix * vec4(p.xyz * (1.0 + behind / length(p.xyz)), 1.0);
    gl_Position.z = back.z / back.w * gl_Position.w;
    gl_PointSize = clamp(side * focal_px / max(1e-6, -p.z), 1.5, 64.0);
  }`;
const kFragment = `
  varying float vGrey;
  void main() {
    gl_FragColor = vec4(vec3(0.2 + 0.78 * vGrey) * vec3(1.0, 0.985, 0.96), 1.0);
  }`;

export class Surfaces {
  constructor(world) {
    this.points = new Points(new BufferGeometry(), new ShaderMaterial({
      vertexShader: kVertex,
      fragmentShader: kFragment,
      uniforms: { side: { value: 1 }, focal_px: { value: 1 }, behind: { value: 0 } },
    }));
    this.points.frustumCulled = false;
    this.points.visible = false;
    world.add(this.points);
  }

  setResolution(width, height) {
    this.height = height;
  }

  setRun(run) {
    if (!run.surfaces || run.surfaces === this.surfaces) return;
    this.surfaces = run.surfaces;
    const { points, low_w, step_m, spacing_m } = run.surfaces;
    const geometry = new BufferGeometry();
    if (points.grey?.length) {
      geometry.setAttribute("position", new BufferAttribute(points.p, 3));
      geometry.setAttribute("facing", new BufferAttribute(points.normal, 3, true));
      geometry.setAttribute("grey", new BufferAttribute(points.grey, 1, true));
    }
    this.points.geometry.dispose();
    this.points.geometry = geometry;
    this.points.position.set(...low_w);
    this.points.scale.setScalar(step_m);
    const { uniforms } = this.points.material;
    uniforms.side.value = kSquare * spacing_m;
    uniforms.behind.value = kBehind * spacing_m;
    this.points.onBeforeRender = (renderer, scene, camera) => {
      uniforms.focal_px.value = 0.5 * this.height * renderer.getPixelRatio() * camera.projectionMatrix.elements[5];
    };
  }

  show(layers) {
    this.points.visible = layers.get("surface") && !!this.surfaces;
  }
}

/** Returns the red, green and blue of a colour "#rrggbb". */
function channelsOf(name) {
  const hex = themeColour(name);
  return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
}

export class FloorGrid {
  /** `drawn()` is called after the picture of the grid has been decoded. */
  constructor(world, drawn) {
    this.drawn = drawn;
    this.level = new Group();
    world.add(this.level);
    this.plane = new Mesh(new PlaneGeometry(1, 1), new MeshBasicMaterial({ transparent: true, side: DoubleSide, depthWrite: false }));
    this.plane.frustumCulled = false;
    this.plane.renderOrder = -1;
    this.plane.visible = false;
    this.level.add(this.plane);
  }

  setRun(run) {
    if (!run.surfaces || run.surfaces === this.surfaces) return;
    this.surfaces = run.surfaces;
    const { grid, spacing_m } = run.surfaces;
    if (!grid) return;
    this.level.quaternion.set(...grid.T_w_level.q_xyzw);
    this.level.position.set(...grid.T_w_level.t_m);
    const [width, height] = [grid.width_px * grid.pixel_m, grid.height_px * grid.pixel_m];
    const [x, y, z] = grid.corner_level;
    // Slightly above the floor, which is as rough.
    this.plane.position.set(x + 0.5 * width, y + 0.5 * height, z + 0.5 * spacing_m);
    this.plane.scale.set(width, height, 1);
    const image = new Image();
    image.onload = () => {
      if (this.surfaces !== run.surfaces) return;
      this.image = image;
      this.paint();
      this.show(this.layers);
      this.drawn();
    };
    image.src = `data:image/png;base64,${grid.png}`;
  }

  /** Draws the picture in the colours of the style; what is unknown is transparent. */
  paint() {
    if (!this.image) return;
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [this.image.width, this.image.height];
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(this.image, 0, 0);
    const pixels = context.getImageData(0, 0, canvas.width, canvas.height);
    const [free, occupied] = [channelsOf("free"), channelsOf("occupied")];
    for (let i = 0; i < pixels.data.length; i += 4) {
      const grey = pixels.data[i];
      pixels.data.set(grey > 230 ? [...free, 180] : grey < 100 ? [...occupied, 255] : [0, 0, 0, 0], i);
    }
    context.putImageData(pixels, 0, 0);
    this.plane.material.map?.dispose();
    const texture = new CanvasTexture(canvas);
    texture.magFilter = NearestFilter;
    texture.colorSpace = "srgb";
    this.plane.material.map = texture;
    this.plane.material.needsUpdate = true;
  }

  retheme() {
    this.paint();
  }

  show(layers) {
    this.layers = layers;
    this.plane.visible = layers.get("floor") && !!this.image && !!this.surfaces?.grid;
  }
}
