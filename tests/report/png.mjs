// SPDX-License-Identifier: BSD-3-Clause
// Reads the pixels of a PNG like browsers' screenshots: 8 bits, RGB or RGBA, not interlaced.
import { inflateSync } from "node:zlib";

function paeth(a, b, c) {
  const p = a + b - c;
  const [pa, pb, pc] = [Math.abs(p - a), Math.abs(p - b), Math.abs(p - c)];
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

const kFilters = [() => 0, (a) => a, (a, b) => b, (a, b) => (a + b) >> 1, paeth];

/** {width, height, channels, data} */
export function decodePng(png) {
  const chunks = [];
  let head = null;
  for (let at = 8; at < png.length; ) {
    const length = png.readUInt32BE(at);
    const type = png.toString("latin1", at + 4, at + 8);
    if (type === "IHDR") head = png.subarray(at + 8, at + 8 + length);
    if (type === "IDAT") chunks.push(png.subarray(at + 8, at + 8 + length));
    at += length + 12;
  }
  const [width, height] = [head.readUInt32BE(0), head.readUInt32BE(4)];
  const channels = { 2: 3, 6: 4 }[head[9]];
  if (head[8] !== 8 || !channels || head[12] !== 0) throw new Error("another kind of PNG");
  const raw = inflateSync(Buffer.concat(chunks));
  const stride = width * channels;
  const data = new Uint8Array(height * stride);
  for (let y = 0; y < height; ++y) {
    const filter = kFilters[raw[y * (stride + 1)]];
    for (let x = 0; x < stride; ++x) {
      const left = x >= channels ? data[y * stride + x - channels] : 0;
      const up = y ? data[(y - 1) * stride + x] : 0;
      const corner = y && x >= channels ? data[(y - 1) * stride + x - channels] : 0;
      data[y * stride + x] = raw[y * (stride + 1) + 1 + x] + filter(left, up, corner);
    }
  }
  return { width, height, channels, data };
}

/** Calls `use(r, g, b)` for each pixel of a part of the picture. */
export function eachPixel({ width, height, channels, data }, box, use) {
  const [x0, y0] = [Math.max(0, Math.ceil(box.x)), Math.max(0, Math.ceil(box.y))];
  const [x1, y1] = [Math.min(width, Math.floor(box.x + box.width)), Math.min(height, Math.floor(box.y + box.height))];
  for (let y = y0; y < y1; ++y) {
    for (let x = x0; x < x1; ++x) {
      const at = (y * width + x) * channels;
      use(data[at], data[at + 1], data[at + 2]);
    }
  }
}
