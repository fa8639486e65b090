// SPDX-License-Identifier: BSD-3-Clause
// node write_mcap.mjs NODE_MODULES FOLDER FILE.mcap [OPTIONS]: writes a folder of images (camera.yaml of a rectified pair, times.txt, groundtruth.txt) as a recording with the format's own library: raw images, camera_info, and the true poses as PoseStamped.
// OPTIONS, in JSON: `writer`: options of @mcap/core's McapWriter; `compression` of chunks by the program of that name (zstd, lz4); `encoding` of messages ("cdr" of ROS 2, "ros1"); `png`: CompressedImage; `odometry`: Odometry as truth; `unsorted`: frames from the last to the first; `late_ms`: logging of right images and their camera_info after their stamps; `jitter_ms`: further delays up to this; `cut`: the file ends after this part of its bytes.
import { execFileSync } from "node:child_process";
import { ftruncateSync, openSync, readdirSync, readFileSync, writeSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { inflateSync } from "node:zlib";

const [modules, folder, file, json] = process.argv.slice(2);
const options = { encoding: "cdr", late_ms: 0, jitter_ms: 0, ...JSON.parse(json ?? "{}") };
const require = createRequire(join(resolve(modules), "x.js"));
const { McapWriter } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const isRos1 = options.encoding === "ros1";
const { MessageWriter } = require(isRos1 ? "@foxglove/rosmsg-serialization" : "@foxglove/rosmsg2-serialization");

const header = "std_msgs/Header header\n";
const stampField = isRos1 ? "uint32 seq\ntime stamp" : "builtin_interfaces/Time stamp";
const headers = `${"=".repeat(80)}\nMSG: std_msgs/Header\n${stampField}\nstring frame_id\n`;
const poses = `${"=".repeat(80)}\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n` +
  `${"=".repeat(80)}\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n` +
  `${"=".repeat(80)}\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n`;
const [d, k, r, p] = isRos1 ? ["D", "K", "R", "P"] : ["d", "k", "r", "p"];
const definitions = {
  "sensor_msgs/msg/Image": `${header}uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n${headers}`,
  "sensor_msgs/msg/CameraInfo": `${header}uint32 height\nuint32 width\nstring distortion_model\nfloat64[] ${d}\nfloat64[9] ${k}\nfloat64[9] ${r}\nfloat64[12] ${p}\n` +
    `uint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n${headers}${"=".repeat(80)}\nMSG: sensor_msgs/RegionOfInterest\n` +
    "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n",
  "sensor_msgs/msg/CompressedImage": `${header}string format\nuint8[] data\n${headers}`,
  "nav_msgs/msg/Odometry": `${header}string child_frame_id\ngeometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n${headers}${poses}` +
    `${"=".repeat(80)}\nMSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n` +
    `${"=".repeat(80)}\nMSG: geometry_msgs/TwistWithCovariance\ngeometry_msgs/Twist twist\nfloat64[36] covariance\n` +
    `${"=".repeat(80)}\nMSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n` +
    `${"=".repeat(80)}\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n`,
  "geometry_msgs/msg/PoseStamped": `${header}geometry_msgs/Pose pose\n${headers}${poses}`,
};

/** Returns the grey pixels of a PNG of 8 bits and one channel. */
function readPng(path) {
  const png = readFileSync(path);
  const width = png.readUInt32BE(16), height = png.readUInt32BE(20);
  if (png[24] !== 8 || png[25] !== 0 || png[28] !== 0) throw new Error(`${path}: not 8 bits of grey`);
  const parts = [];
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
    if (png.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
  }
  const raw = inflateSync(Buffer.concat(parts));
  const data = new Uint8Array(width * height);
  for (let y = 0; y < height; ++y) {
    const filter = raw[y * (width + 1)];
    for (let x = 0; x < width; ++x) {
      const a = x > 0 ? data[y * width + x - 1] : 0, b = y > 0 ? data[(y - 1) * width + x] : 0;
      const c = x > 0 && y > 0 ? data[(y - 1) * width + x - 1] : 0;
      const p = a + b - c, pa = Math.abs(p - a), pb = Math.abs(p - b), pc = Math.abs(p - c);
      const paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
      data[y * width + x] = raw[y * (width + 1) + 1 + x] + [0, a, b, (a + b) >> 1, paeth][filter];
    }
  }
  return { width, height, data };
}

const yaml = readFileSync(join(folder, "camera.yaml"), "utf8");
const numbers = (key) => new RegExp(`${key}: \\[?([-0-9.e, ]+)`).exec(yaml)[1].split(",").map(Number);
const [fx, fy] = numbers("focal_length_px"), [cx, cy] = numbers("principal_point_px"), [b] = numbers("baseline_m");
const images = (side) => readdirSync(join(folder, side)).sort().map((name) => join(folder, side, name));
const left = images("left"), right = images("right");
const rows = (name) => readFileSync(join(folder, name), "utf8").split("\n").filter((row) => row && !row.startsWith("#"));
const toNs = (text) => {
  const [seconds, decimals = ""] = text.trim().split(".");
  return BigInt(seconds) * 1_000_000_000n + BigInt(decimals.slice(0, 9).padEnd(9, "0"));
};

const fd = openSync(file, "w");
let position = 0n;
const writer = new McapWriter({
  writable: {
    position: () => position,
    write: async (bytes) => {
      writeSync(fd, bytes);
      position += BigInt(bytes.byteLength);
    },
  },
  chunkSize: 300_000,
  compressChunk: options.compression && ((bytes) => ({
    compression: options.compression,
    compressedData: new Uint8Array(execFileSync(options.compression, ["-q", "-c"], { input: bytes, maxBuffer: 2 ** 26 })),
  })),
  ...options.writer,
});
await writer.start({ profile: isRos1 ? "ros1" : "ros2", library: "" });
const channels = new Map();
async function write(topic, type, t_ns, value) {
  if (!channels.has(topic)) {
    const name = isRos1 ? type.replace("/msg/", "/") : type;
    const schemaId = await writer.registerSchema({ name, encoding: isRos1 ? "ros1msg" : "ros2msg", data: new TextEncoder().encode(definitions[type]) });
    const id = await writer.registerChannel({ topic, schemaId, messageEncoding: options.encoding, metadata: new Map() });
    channels.set(topic, { id, sequence: 0, bytes: new MessageWriter(parse(definitions[type], { ros2: !isRos1 })) });
  }
  const channel = channels.get(topic);
  const sec = Number(t_ns / 1_000_000_000n), nsec = Number(t_ns % 1_000_000_000n);
  const stamp = isRos1 ? { sec, nsec } : { sec, nanosec: nsec };
  const data = channel.bytes.writeMessage({ header: { seq: channel.sequence, stamp, frame_id: "camera" }, ...value });
  const late_ms = (topic.includes("/right/") ? options.late_ms : 0) + options.jitter_ms * ((channel.sequence * 37) % 11) / 10;
  const logTime = t_ns + BigInt(Math.round(1e6 * late_ms));
  await writer.addMessage({ channelId: channel.id, sequence: channel.sequence++, logTime, publishTime: t_ns, data });
}

const roi = { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false };
const times = [...rows("times.txt").entries()];
for (const [i, time] of options.unsorted ? times.reverse() : times) {
  const t_ns = toNs(time);
  for (const [side, path] of [["right", right[i]], ["left", left[i]]]) {
    const { width, height, data } = readPng(path);
    const info = {
      [d]: [0, 0, 0, 0, 0], [k]: [fx, 0, cx, 0, fy, cy, 0, 0, 1], [r]: [1, 0, 0, 0, 1, 0, 0, 0, 1],
      [p]: [fx, 0, cx, side === "right" ? -fx * b : 0, 0, fy, cy, 0, 0, 0, 1, 0],
    };
    await write(`/stereo/${side}/camera_info`, "sensor_msgs/msg/CameraInfo", t_ns,
      { height, width, distortion_model: "plumb_bob", ...info, binning_x: 0, binning_y: 0, roi });
    if (options.png) {
      await write(`/stereo/${side}/image_raw/compressed`, "sensor_msgs/msg/CompressedImage", t_ns, { format: "mono8; png compressed ", data: readFileSync(path) });
    } else {
      await write(`/stereo/${side}/image_raw`, "sensor_msgs/msg/Image", t_ns, { height, width, encoding: "mono8", is_bigendian: 0, step: width, data });
    }
  }
}
for (const row of rows("groundtruth.txt")) {
  const [time, x, y, z, qx, qy, qz, qw] = row.split(" ");
  const orientation = { x: Number(qx), y: Number(qy), z: Number(qz), w: Number(qw) };
  const pose = { position: { x: Number(x), y: Number(y), z: Number(z) }, orientation };
  if (options.odometry) {
    const covariance = new Array(36).fill(0), zero = { x: 0, y: 0, z: 0 };
    await write("/gt/odom", "nav_msgs/msg/Odometry", toNs(time),
      { child_frame_id: "base_link", pose: { pose, covariance }, twist: { twist: { linear: zero, angular: zero }, covariance } });
  } else {
    await write("/ground_truth", "geometry_msgs/msg/PoseStamped", toNs(time), { pose });
  }
}
await writer.end();
if (options.cut) ftruncateSync(fd, Math.floor(Number(position) * options.cut));
