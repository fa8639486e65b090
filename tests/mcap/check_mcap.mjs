// SPDX-License-Identifier: BSD-3-Clause
// node check_mcap.mjs NODE_MODULES FILE.mcap FOLDER [IMAGES]: reads the file with the format's own libraries, decodes every message by its schema,
// and compares it with the files of a run in FOLDER if they exist (trajectories, keyframes.tum, map.ply, poses.csv).
// Prints its findings as JSON, with `failures`. Images are written to the folder IMAGES, named by their times.
import { closeSync, existsSync, openSync, readFileSync, readSync, statSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import * as zlib from "node:zlib";

const [modules, file, folder, images] = process.argv.slice(2);
const require = createRequire(join(resolve(modules), "x.js"));
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { decompress } = require("fzstd");

const failures = [];
const fail = (text) => failures.push(text);
const zstd = { zstd: (bytes, size) => decompress(new Uint8Array(bytes), new Uint8Array(Number(size))) };
const bytes = readFileSync(file);
const time_ns = (stamp) => BigInt(stamp.sec) * 1_000_000_000n + BigInt(stamp.nanosec);

/** Returns all records in the order of the file; throws if a checksum is wrong. */
function stream(content) {
  const reader = new McapStreamReader({ decompressHandlers: zstd, validateCrcs: true });
  reader.append(content);
  const records = [];
  for (let record; (record = reader.nextRecord()); ) records.push(record);
  if (!reader.done()) throw new Error("the file does not end as one should");
  return records;
}

/** Returns decoded messages by topic, through the index. */
async function decoded() {
  const fd = openSync(file, "r");
  const readable = {
    size: async () => BigInt(statSync(file).size),
    read: async (offset, length) => {
      const part = new Uint8Array(Number(length));
      readSync(fd, part, 0, part.length, Number(offset));
      return part;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: zstd });
  const readers = new Map();
  const topics = {};
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (channel.messageEncoding !== "cdr" || schema.encoding !== "ros2msg") fail(`${channel.topic}: another encoding`);
    if (!readers.has(schema.id)) {
      readers.set(schema.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
    }
    if (message.logTime < last) fail(`${channel.topic}: time goes back`);
    last = message.logTime;
    const value = readers.get(schema.id).readMessage(message.data);
    if (readers.get(schema.id).lastReadHadTrailingBytes()) fail(`${channel.topic}: more bytes than its type has`);
    (topics[channel.topic] ??= []).push({ type: schema.name, t_ns: message.logTime, value });
  }
  closeSync(fd);
  const counts = {};
  for (const [id, n] of reader.statistics.channelMessageCounts) counts[reader.channelsById.get(id).topic] = Number(n);
  for (const topic of Object.keys(topics)) {
    if (counts[topic] !== topics[topic].length) fail(`${topic}: statistics have ${counts[topic]} messages`);
  }
  if (reader.header.profile !== "ros2") fail(`profile ${reader.header.profile}`);
  return { topics, dataSectionCrc: reader.dataSectionCrc, chunks: reader.chunkIndexes };
}

const hasFile = (name) => existsSync(join(folder, name));
const rowsOf = (name) => readFileSync(join(folder, name), "utf8").split("\n").filter((row) => row && !row.startsWith("#"));
const toNs = (text) => {
  const [seconds, decimals = ""] = text.split(".");
  return BigInt(seconds) * 1_000_000_000n + BigInt(decimals.padEnd(9, "0"));
};

/** Compares [times, position, orientation] of a topic with the rows of a file in TUM's format. */
function comparePoses(topic, list, file) {
  const rows = rowsOf(file);
  if (list.length !== rows.length) fail(`${topic}: ${list.length} poses instead of ${rows.length}`);
  list.slice(0, rows.length).forEach(([times, p, q], i) => {
    const [t, ...numbers] = rows[i].split(" ");
    for (const time of times) if (toNs(t) !== time) fail(`${topic}[${i}]: time ${time} instead of ${t}`);
    const read = [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
    // The file has nine decimals of a position, so half of the last one is not a difference.
    read.forEach((x, k) => Math.abs(x - Number(numbers[k])) > 1e-9 && fail(`${topic}[${i}]: ${x} instead of ${numbers[k]}`));
  });
}

function compareFrames(topics) {
  const transforms = topics["/tf"].map(({ t_ns, value }) => {
    const { header, transform } = value.transforms[0];
    return [[t_ns, time_ns(header.stamp)], transform.translation, transform.rotation];
  });
  comparePoses("/tf", transforms, "trajectory.tum");
  const odometry = topics["/odom"].map(({ t_ns, value }) => [[t_ns, time_ns(value.header.stamp)], value.pose.pose.position, value.pose.pose.orientation]);
  comparePoses("/odom", odometry, "trajectory.tum");
  const poses = topics["/pose"].map(({ t_ns, value }) => [[t_ns, time_ns(value.header.stamp)], value.pose.pose.position, value.pose.pose.orientation]);
  comparePoses("/pose", poses, "trajectory.tum");
  topics["/pose"].forEach(({ value }, i) => {
    if (String(value.pose.covariance) !== String(topics["/odom"][i].value.pose.covariance)) fail(`/pose[${i}]: another covariance than /odom`);
  });
  for (const [topic, name] of [["/path", "trajectory.tum"], ["/path_live", "trajectory_live.tum"], ["/path_truth", "groundtruth.tum"]]) {
    if (hasFile(name) !== topic in topics) fail(`${topic} is there, or ${name}, but not both`);
    if (!(topic in topics)) continue;
    const path = topics[topic][0].value.poses.map((p) => [[time_ns(p.header.stamp)], p.pose.position, p.pose.orientation]);
    comparePoses(topic, path, name);
  }
}

/** Compares all columns of all rows, except the time, which is that of the message, and the state, which is its text. */
function compareDiagnostics(list) {
  const [names, ...rows] = rowsOf("poses.csv").map((row) => row.split(","));
  if (list.length !== rows.length) fail(`/diagnostics: ${list.length} instead of ${rows.length}`);
  list.slice(0, rows.length).forEach(({ t_ns, value }, i) => {
    const [status] = value.status;
    const read = { t_s: rows[i][names.indexOf("t_s")], state: status.message, ...Object.fromEntries(status.values.map(({ key, value: text }) => [key, text])) };
    if (toNs(read.t_s) !== t_ns || time_ns(value.header.stamp) !== t_ns) fail(`/diagnostics[${i}]: time ${t_ns}`);
    names.forEach((name, k) => read[name] !== rows[i][k] && fail(`/diagnostics[${i}]: ${name} is ${read[name]} instead of ${rows[i][k]}`));
    if (status.level !== (status.message === "lost" ? 2 : status.message === "tracking" ? 0 : 1)) fail(`/diagnostics[${i}]: level ${status.level}`);
  });
}

/** Compares vertices and edges of map.ply by their bytes. */
function readPly() {
  const ply = readFileSync(join(folder, "map.ply"));
  const head = ply.indexOf("end_header\n") + "end_header\n".length;
  const count = (name) => Number(new RegExp(`element ${name} (\\d+)`).exec(ply.subarray(0, head).toString())[1]);
  const vertices = [];
  for (let i = 0; i < count("vertex"); ++i) {
    const at = head + 19 * i;
    vertices.push({ p: [0, 4, 8].map((k) => ply.readFloatLE(at + k)), rgb: [12, 13, 14].map((k) => ply[at + k]), n: ply.readInt32LE(at + 15) });
  }
  return { vertices, lines: count("edge") };
}

function compareMap(topics) {
  const { vertices, lines } = readPly();
  const cloud = topics["/map/points"][0].value;
  const data = new DataView(cloud.data.buffer, cloud.data.byteOffset, cloud.data.byteLength);
  const at = Object.fromEntries(cloud.fields.map((field) => [field.name, field.offset]));
  const n = vertices.length - 2 * lines;
  if (cloud.width !== n || cloud.data.length !== n * cloud.point_step) fail(`/map/points: ${cloud.width} points instead of ${n}`);
  for (let i = 0; i < n; ++i) {
    const from = i * cloud.point_step;
    const same = ["x", "y", "z"].every((name, k) => data.getFloat32(from + at[name], true) === vertices[i].p[k]) &&
      [2, 1, 0].every((k, j) => data.getUint8(from + at.rgb + k) === vertices[i].rgb[j]) &&
      data.getUint32(from + at.observations, true) === vertices[i].n;
    if (!same) fail(`/map/points: point ${i} is another one`);
  }
  const marker = topics["/map/lines"][0].value;
  if (marker.points.length !== 2 * lines || marker.colors.length !== 2 * lines) fail(`/map/lines: not ${lines} lines`);
  marker.points.forEach((p, i) => {
    const vertex = vertices[n + i];
    if (![p.x, p.y, p.z].every((x, k) => Math.fround(x) === vertex.p[k])) fail(`/map/lines: end ${i} is another one`);
    const c = marker.colors[i];
    if (![c.r, c.g, c.b].every((x, k) => Math.round(255 * x) === vertex.rgb[k])) fail(`/map/lines: colour ${i} is another one`);
  });
  return { points: n, lines };
}

/** Checks that the reader detects a flipped byte in the middle of a chunk by the writer's checksums. */
function flippedByteIsSeen(chunks) {
  for (const chunk of [chunks[0], chunks.at(-1)]) {
    const damaged = new Uint8Array(bytes);
    const at = Number(chunk.chunkStartOffset) + Math.floor(Number(chunk.chunkLength) / 2);
    damaged[at] ^= 1;
    try {
      stream(damaged);
      fail(`a flipped byte at ${at} is not noticed`);
    } catch {
      // as expected
    }
  }
}

const records = stream(bytes);
const { topics, dataSectionCrc, chunks } = await decoded();
// DataEnd: its type, eight bytes of length, and the checksum of all previous bytes.
const end = records.find((record) => record.type === "DataEnd");
const footer = records.find((record) => record.type === "Footer");
const data = bytes.subarray(0, Number(footer.summaryStart) - 13);
const crc = zlib.crc32?.(data); // from Node 20.15 on
if (crc !== undefined && crc !== end.dataSectionCrc) fail(`checksum of the data is ${crc}, not ${end.dataSectionCrc}`);
if (dataSectionCrc === undefined || footer.summaryCrc === 0) fail("there is no checksum of the data or of the summary");
flippedByteIsSeen(chunks);
if (hasFile("trajectory.tum") && topics["/odom"]) compareFrames(topics);
if (hasFile("poses.csv") && topics["/diagnostics"]) compareDiagnostics(topics["/diagnostics"]);
if (hasFile("keyframes.tum") && topics["/keyframes"]) {
  comparePoses("/keyframes", topics["/keyframes"][0].value.poses.map((pose) => [[], pose.position, pose.orientation]), "keyframes.tum");
}
const map = hasFile("map.ply") && topics["/map/points"] ? compareMap(topics) : {};
const pictures = topics["/camera/left/compressed"] ?? [];
if (images) for (const { t_ns, value } of pictures) writeFileSync(join(images, `${t_ns}.${value.format}`), value.data);
const camera = topics["/camera/left/camera_info"]?.[0].value;
const odometry = topics["/odom"]?.at(-1).value;
console.log(JSON.stringify({
  topics: Object.fromEntries(Object.entries(topics).map(([topic, list]) => [topic, { type: list[0].type, n: list.length }])),
  chunks: chunks.length,
  ...map,
  camera: camera && { k: [...camera.k], d: [...camera.d], model: camera.distortion_model, size: [camera.width, camera.height] },
  formats: [...new Set(pictures.map(({ value }) => value.format))],
  loops: topics["/loops"]?.[0].value.points,
  covariance: odometry && [...odometry.pose.covariance],
  orientation: odometry && odometry.pose.pose.orientation,
  speed: odometry && odometry.twist.twist.linear,
  state: topics["/diagnostics"]?.at(-1).value.status[0],
  world: topics["/tf_static"]?.[0].value.transforms[0],
  failures: failures.slice(0, 20),
}));
