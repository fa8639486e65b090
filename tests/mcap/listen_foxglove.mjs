// SPDX-License-Identifier: BSD-3-Clause
// node listen_foxglove.mjs NODE_MODULES PORT SECONDS [OPTIONS]: for so long, or until SIGTERM, connects to `plslam bridge` as a viewer does, with the protocol's own client, subscribes to all channels, decodes every message by its schema, and prints its findings as JSON, with `failures`.
// OPTIONS, in JSON: `protocol`: the WebSocket protocol; `calls`: services to call, one after the other ({name: request}), `call_after_s`; `stop_reading_s`: takes nothing from the socket for so long; `origin`: of a web page; `topics`: instead of all.
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

const [modules, port, seconds, json] = process.argv.slice(2);
const options = { protocol: "foxglove.websocket.v1", calls: {}, call_after_s: 0, stop_reading_s: 0, ...JSON.parse(json ?? "{}") };
const require = createRequire(join(resolve(modules), "x.js"));
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg2-serialization");
const WebSocket = require("ws");

const found = { failures: [], topics: {}, services: [], answers: {}, statuses: [], parameters: {}, odom: [] };
const finish = () => {
  console.log(JSON.stringify(found));
  process.exit(0);
};
const socket = new WebSocket(`ws://127.0.0.1:${port}`, [options.protocol], options.origin ? { origin: options.origin } : {});
socket.on("unexpected-response", (_, response) => {
  let text = "";
  response.on("data", (part) => (text += part));
  response.on("end", () => {
    found.refused = { status: response.statusCode, text };
    finish();
  });
});
const client = new FoxgloveClient({ ws: socket });
client.on("error", (error) => found.failures.push(String(error)));
client.on("close", () => (found.closed = true));
client.on("status", ({ message }) => found.statuses.push(message));
client.on("serverInfo", ({ capabilities, supportedEncodings }) => Object.assign(found, { capabilities, supportedEncodings }));

const readers = new Map();
client.on("advertise", (channels) => {
  for (const channel of channels) {
    if (channel.encoding !== "cdr" || channel.schemaEncoding !== "ros2msg") found.failures.push(`${channel.topic}: another encoding`);
    found.topics[channel.topic] = { type: channel.schemaName, n: 0, last_ns: "0", bytes: 0 };
    if (options.topics && !options.topics.includes(channel.topic)) continue;
    const reader = new MessageReader(parse(channel.schema, { ros2: true }));
    readers.set(client.subscribe(channel.id), { channel, reader });
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const { channel, reader } = readers.get(subscriptionId);
  const topic = found.topics[channel.topic];
  try {
    const value = reader.readMessage(data);
    if (reader.lastReadHadTrailingBytes()) found.failures.push(`${channel.topic}: more bytes than its type has`);
    if (channel.topic === "/odom") {
      const { position: p, orientation: q } = value.pose.pose;
      found.odom.push([String(timestamp), p.x, p.y, p.z, q.x, q.y, q.z, q.w]);
    }
    if (channel.topic === "/map/points") topic.points = value.width;
    if (channel.topic === "/camera/left/compressed") topic.first_bytes = Array.from(value.data.slice(0, 2));
  } catch (error) {
    found.failures.push(`${channel.topic}: ${error}`);
  }
  if (BigInt(topic.last_ns) > timestamp) found.failures.push(`${channel.topic}: time goes back`);
  Object.assign(topic, { n: topic.n + 1, last_ns: String(timestamp), bytes: topic.bytes + data.byteLength });
});

const services = new Map();
let nextCall = 1;
const waiting = new Map();
client.on("advertiseServices", (list) => {
  for (const service of list) {
    services.set(service.name, service);
    found.services.push(`${service.name} ${service.type}`);
  }
  setTimeout(() => callNext(Object.entries(options.calls)), 1000 * options.call_after_s);
});
function callNext([first, ...rest]) {
  if (!first) return;
  const [name, request] = first;
  const service = services.get(name);
  const callId = nextCall++;
  waiting.set(callId, (answer) => {
    found.answers[name] = answer;
    callNext(rest);
  });
  const bytes = new MessageWriter(parse(service.request.schema, { ros2: true })).writeMessage(request);
  client.sendServiceCallRequest({ serviceId: service.id, callId, encoding: "cdr", data: new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength) });
}
client.on("serviceCallResponse", ({ serviceId, callId, data }) => {
  const service = [...services.values()].find(({ id }) => id === serviceId);
  waiting.get(callId)(new MessageReader(parse(service.response.schema, { ros2: true })).readMessage(data));
});
client.on("serviceCallFailure", ({ callId, message }) => waiting.get(callId)({ failure: message }));
client.on("parameterValues", ({ parameters }) => {
  for (const { name, value } of parameters) found.parameters[name] = value;
});
client.on("open", () => {
  if (options.stop_reading_s > 0) {
    setTimeout(() => socket.pause(), 500);
    setTimeout(() => socket.resume(), 500 + 1000 * options.stop_reading_s);
  }
  setTimeout(() => client.setParameters([{ name: "vo.features.use", value: "points" }], "set"), 1000);
  const end = () => {
    client.getParameters([], "all");
    setTimeout(finish, 1000);
  };
  setTimeout(end, 1000 * seconds);
  process.on("SIGTERM", end);
});
