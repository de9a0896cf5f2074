#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// A stand-in for the Fanlight server, for work on the page: serves dist/ and speaks the protocol.
//   fake_server.mjs serve [--source phantom:] [--listen 127.0.0.1:8080] [--probe-control everyone]
// A source with "volumes=1", or a replay, has one volume; any other has one every 200 ms. A source that begins with
// "usb:" is a probe; POST /unplug removes it and POST /plug returns it.
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { WebSocketServer } from "ws";
import { ClientMessageSchema, SceneSchema, ServerMessageSchema } from "../generated/fanlight_pb.js";
import { defaults, fields } from "./fields.mjs";
import { fakePicture } from "./fake_picture.mjs";
import { FakeProbe } from "./fake_probe.mjs";

const { values: options } = parseArgs({
  allowPositionals: true,
  options: {
    source: { type: "string", default: "phantom:" },
    listen: { type: "string", default: "127.0.0.1:8080" },
    "probe-control": { type: "string", default: "everyone" },
  },
});
const standsStill = /volumes=1\b|^replay:/.test(options.source);
const kFramesPerVolume = 35n;
const kVolumesPerLoss = 10n; // for a probe: every tenth volume lacks two frames
const probe = options.source.startsWith("usb:") ? new FakeProbe(options["probe-control"] === "everyone") : undefined;
const kMismatch = { mismatchDeg: 1.0204, mismatchLeftDeg: 0.031, mismatchLeftMm: 0.0649 };
const kNoProbe = {
  case: "refused",
  value: { message: "there is no probe to set, expected a source such as usb:1209:0001" },
};

const scene = { ...defaults };
let revision = 1n;
let volumeId = 0n;
let captureTime_ns = 0n;
let pass1Runs = 0n;
let pass2Runs = 0n;
let pictureId = 0n;
let newestPicture;
let stale = false;

const pages = {
  "/": ["index.html", "text/html; charset=utf-8"],
  "/viewer.js": ["viewer.js", "text/javascript; charset=utf-8"],
  "/archive_form.js": ["archive_form.js", "text/javascript; charset=utf-8"],
  "/transfer_editor.js": ["transfer_editor.js", "text/javascript; charset=utf-8"],
  "/clip.js": ["clip.js", "text/javascript; charset=utf-8"],
  "/viewer.css": ["viewer.css", "text/css; charset=utf-8"],
  "/favicon.svg": ["favicon.svg", "image/svg+xml"],
};
const headers = {
  "Content-Security-Policy":
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; " +
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
  "X-Content-Type-Options": "nosniff",
  "Cache-Control": "no-cache",
};
const commands = probe && { "/plug": () => probe.plug(), "/unplug": () => probe.unplug() };
const http = createServer((request, response) => {
  const command = request.method === "POST" && commands?.[request.url];
  if (command) {
    command();
    tellProbe();
    tellLiveness();
    return response.writeHead(204).end();
  }
  const [name, type] = pages[request.url] ?? [];
  if (!name) return response.writeHead(404).end();
  const file = fileURLToPath(new URL(`../dist/${name}`, import.meta.url));
  response.writeHead(200, { ...headers, "Content-Type": type }).end(readFileSync(file));
});
const streams = new WebSocketServer({ server: http, path: "/stream" });
const sessions = new Map(); // socket -> { offered, sent }

streams.on("connection", (socket) => {
  sessions.set(socket, { offered: 0n, sent: 0n });
  socket.on("close", () => sessions.delete(socket));
  socket.on("message", (bytes) => answer(socket, fromBinary(ClientMessageSchema, bytes).body));
  tell(socket, "hello", {
    protocolVersion: 2,
    serverVersion: "fake",
    source: options.source,
    device: "no GPU: synthetic pictures",
    pictureWidth: 320,
    pictureHeight: 320,
    fields,
    scene: { revision, scene: message(scene) },
    defaultScene: message(defaults),
  });
  if (probe) tell(socket, "probeStatus", probe.status());
  tell(socket, "liveness", livenessNow());
  if (newestPicture) offer(socket, newestPicture);
});

function answer(socket, { case: kind, value }) {
  if (kind === "clockRequest") {
    tell(socket, "clockReply", { clientTimeMs: value.clientTimeMs, serverTimeNs: process.hrtime.bigint() });
    return;
  }
  if (kind === "probeChange") {
    const outcome = probe?.change(value.settings) ?? kNoProbe;
    tell(socket, "probeReply", { requestId: value.requestId, outcome });
    if (outcome.case === "inForce") tellProbe();
    return;
  }
  if (kind !== "sceneChange") return; // what this stand-in does not have
  const changed = changesOf(value.scene);
  const refusal = refusalOf({ ...scene, ...changed });
  if (refusal) {
    tell(socket, "sceneReply", {
      requestId: value.requestId,
      outcome: { case: "refused", value: { message: refusal } },
    });
    return;
  }
  const casts = fields.some(({ name, castsRays }) => castsRays && name in changed && changed[name] !== scene[name]);
  Object.assign(scene, changed);
  revision += 1n;
  if (casts) pass1Runs += 1n;
  stale = true;
  const state = { revision, scene: message(scene) };
  tell(socket, "sceneReply", { requestId: value.requestId, outcome: { case: "inForce", value: state } });
  for (const other of sessions.keys()) tell(other, "scene", state);
}

function refusalOf(candidate) {
  for (const { name, minimum, maximum, step, unit, isText } of fields) {
    const value = candidate[name];
    if (name === "cuts.shapes") continue; // the real server reads them
    if (isText) {
      if (value.split(",").every((point) => /^ *\d+ +#[0-9a-f]{6} +0?\.?\d+ *$/i.test(point))) continue;
      return `${name}: some point cannot be read, expected 1 to 16 points "LEVEL #RRGGBB OPACITY" separated by commas`;
    }
    if (value >= minimum && value <= maximum && (step === 0 || (value - minimum) % step === 0)) continue;
    return `${name} is ${value}, expected a number from ${minimum} to ${maximum} ${unit}`;
  }
  if (candidate["rays.start_mm"] < candidate["rays.end_mm"]) return undefined;
  return `rays.start_mm is ${candidate["rays.start_mm"]} and rays.end_mm is ${candidate["rays.end_mm"]}, expected the start before the end`;
}

function takeVolume() {
  if (probe && !probe.plugged) return;
  volumeId += 1n;
  captureTime_ns = process.hrtime.bigint();
  pass1Runs += 1n;
  stale = true;
}

function render() {
  if (!stale || volumeId === 0n) return;
  stale = false;
  pass2Runs += 1n;
  pictureId += 1n;
  const before_ms = performance.now();
  const picture = fakePicture(scene, standsStill ? 0 : Number(volumeId) / 10);
  newestPicture = {
    pictureId,
    volumeId,
    captureTimeNs: captureTime_ns,
    finishedTimeNs: process.hrtime.bigint(),
    sceneRevision: revision,
    firstFrameSequence: (volumeId - 1n) * kFramesPerVolume,
    lastFrameSequence: volumeId * kFramesPerVolume - 1n,
    framesMissing: probe && volumeId % kVolumesPerLoss === 0n ? 4 : 0,
    angleCorrectionDeg: probe ? kMismatch.mismatchDeg / 2 : 0,
    pass1Runs,
    pass2Runs,
    ...(scene["deadline.plan"] !== 0 && { deadlineLevel: 2, measures: ["coarse picture"] }),
    ...picture,
    stages: ["upload", "cast", "filter", "light", "finish", "read_back"].map((name) => ({
      name,
      milliseconds: name === "light" ? performance.now() - before_ms : 0,
    })),
  };
  for (const socket of sessions.keys()) offer(socket, newestPicture);
}

function offer(socket, picture) {
  const session = sessions.get(socket);
  session.offered += 1n;
  if (socket.bufferedAmount > 0) return;
  session.sent += 1n;
  tell(socket, "picture", picture);
}

/** The fake server's pictures are live, except while its probe is unplugged. */
function livenessNow() {
  const lost = Boolean(probe && !probe.plugged);
  const age_s = Number(process.hrtime.bigint() - captureTime_ns) / 1e9;
  return lost
    ? { state: 3, cause: 3, sentence: "The probe is lost.", ageS: age_s, limitS: 2 }
    : { state: volumeId > 0n ? 1 : 0, sentence: "The picture is live.", ageS: age_s, picturesPerSecond: 10, limitS: 2 };
}

function tellLiveness() {
  for (const socket of sessions.keys()) tell(socket, "liveness", livenessNow());
}

function tellStatistics() {
  tellLiveness();
  for (const [socket, { offered, sent }] of sessions) {
    tell(socket, "statistics", {
      serverTimeNs: process.hrtime.bigint(),
      framesReceived: volumeId * kFramesPerVolume,
      volumesAssembled: volumeId,
      pass1Runs,
      pass2Runs,
      picturesRendered: pictureId,
      picturesOffered: offered,
      picturesSent: sent,
      picturesSkipped: offered - sent,
      sessions: sessions.size,
      sourceState: probe && !probe.plugged ? "probe lost" : "running",
      ...(probe && { volumesInterpolated: volumeId / kVolumesPerLoss, framesLost: (volumeId / kVolumesPerLoss) * 2n }),
      ...(probe && kMismatch),
    });
  }
}

function tellProbe() {
  for (const socket of sessions.keys()) tell(socket, "probeStatus", probe.status());
}

function tell(socket, kind, value) {
  socket.send(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body: { case: kind, value } })));
}

function message(values) {
  const nested = {};
  for (const [name, value] of Object.entries(values)) {
    const [group, part] = name.split(".");
    if (part) (nested[group] ??= {})[camel(part)] = value;
    else nested[group] = value;
  }
  return create(SceneSchema, nested);
}

function changesOf(whole) {
  const changed = {};
  for (const { name } of fields) {
    const [group, part] = name.split(".");
    const holder = part ? whole[group] : whole;
    const value = holder?.[camel(part ?? group)];
    if (value !== undefined) changed[name] = value;
  }
  return changed;
}

function camel(name) {
  return name.replace(/_(.)/g, (_, letter) => letter.toUpperCase());
}

setTimeout(takeVolume, 300);
if (!standsStill) setInterval(takeVolume, 200);
setInterval(render, 20);
setInterval(tellStatistics, 1000);
const [host, port] = options.listen.split(":");
http.listen(Number(port), host, () => console.log(`listening on http://${host}:${http.address().port}/`));
