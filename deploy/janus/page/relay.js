// SPDX-License-Identifier: Apache-2.0
// A far display: shows the pictures of one mountpoint with what holds of them.
//   index.html?janus=ws://HOST:8188&mountpoint=1[&pin=...][&stun=stun:HOST:3478]
import { JanusStream } from "./janus_stream.js";

// Of a picture that is shown as live, as on displays in the room.
const OLDEST_LIVE_S = 3;
const KEPT_PICTURES = 64;

const byId = (id) => document.getElementById(id);
const query = new URLSearchParams(location.search);
const usual = `${location.protocol === "https:" ? "wss" : "ws"}://${location.hostname || "127.0.0.1"}:8188`;
const video = byId("video");
const marks = byId("marks");

const said = new Map(); // of the last pictures, by RTP timestamp
let shown = null; // what is said of the picture on the screen
let trouble = "connects";
let points = []; // of the measurement, in pixels of the video

const stream = new JanusStream({
  url: query.get("janus") ?? usual,
  mountpoint: Number(query.get("mountpoint") ?? 1),
  pin: query.get("pin") ?? "",
  iceServers: query.get("stun") ? [{ urls: query.get("stun") }] : [],
  onstream: (media) => {
    video.srcObject = media;
    video.play().catch(() => {}); // it is muted, so that it may
  },
  ondata: (timestamp, data) => {
    said.set(timestamp, data);
    if (said.size > KEPT_PICTURES) said.delete(said.keys().next().value);
  },
  onstate: (sentence) => {
    trouble = sentence;
  },
});

/** Age of a picture's volume in seconds, by the clocks of both machines. */
const ageOf = (data) => Date.now() / 1000 - Number(data.capture_utc_ns) / 1e9;

/** For tests: ages of the pictures as they were shown, and the time since they were sent; the newest last. */
const shown_ages = [];

function pictureShown(_now, metadata) {
  const data = said.get(metadata.rtpTimestamp);
  if (data) {
    const is_new = data.picture.picture_id !== shown?.picture.picture_id;
    shown = data;
    if (is_new) shown_ages.push({ age_s: ageOf(data), travel_s: Date.now() / 1000 - Number(data.sent_utc_ns) / 1e9 });
    if (shown_ages.length > 1000) shown_ages.shift();
  }
  video.requestVideoFrameCallback(pictureShown);
}
video.requestVideoFrameCallback(pictureShown);

function tell() {
  const state = byId("state");
  const age_s = shown ? ageOf(shown) : null;
  const is_late = age_s !== null && age_s > OLDEST_LIVE_S;
  const kind = !shown ? "waiting" : trouble || (shown.state === "live" && is_late) ? "not live" : shown.state;
  const words = { live: "Live", replay: "Replay", frozen: "Frozen", waiting: "Waiting", delayed: "Delayed" };
  state.dataset.state = kind;
  state.textContent = words[kind] ?? "Not live";
  byId("stage").classList.toggle("old", !["live", "replay", "frozen", "delayed"].includes(kind));
  byId("title").textContent = shown?.title || "Fanlight";
  byId("sentence").textContent = trouble
    ? `No new picture: ${trouble}.`
    : kind === "not live" && shown.state === "live"
      ? "The newest picture is old: none comes, or the clocks of the two machines differ."
      : (shown?.sentence ?? "Waits for the first picture.");
  byId("age").textContent = age_s === null ? "-" : `${age_s.toFixed(age_s < 10 ? 2 : 0)} s`;
  byId("picture").textContent = shown ? shown.picture.picture_id : "-";
}
setInterval(tell, 200);

async function countLosses() {
  const report = await stream.peer?.getStats();
  for (const entry of report?.values() ?? []) {
    if (entry.type !== "inbound-rtp") continue;
    byId("lost").textContent = `${entry.packetsLost} of ${entry.packetsReceived + entry.packetsLost}`;
  }
}
setInterval(() => countLosses().catch(() => {}), 1_000);

/** Where the video lies in its box, which has other proportions: pixels of the screen for each of the video. */
function placeOfVideo() {
  const box = video.getBoundingClientRect();
  const scale = Math.min(box.width / video.videoWidth, box.height / video.videoHeight);
  return {
    scale,
    left: (box.width - scale * video.videoWidth) / 2,
    top: (box.height - scale * video.videoHeight) / 2,
  };
}

/** Millimetres between two pixels in the plane of the picture; null where the view has a perspective. */
function distance_mm([a, b]) {
  const view = shown?.picture.view;
  if (!view?.mm_per_pixel || view.mm_per_pixel_per_mm) return null;
  return view.mm_per_pixel * Math.hypot(a.x - b.x, a.y - b.y);
}

function draw() {
  const { scale, left, top } = placeOfVideo();
  const at = (point) => [left + (point.x + 0.5) * scale, top + (point.y + 0.5) * scale];
  let drawn = points.map((point) => `<circle cx="${at(point)[0]}" cy="${at(point)[1]}" r="6"/>`).join("");
  if (points.length === 2) {
    const [[x1, y1], [x2, y2]] = points.map(at);
    drawn += `<line x1="${x1}" y1="${y1}" x2="${x2}" y2="${y2}"/>`;
  }
  marks.innerHTML = drawn;
}

marks.addEventListener("click", (event) => {
  const { scale, left, top } = placeOfVideo();
  const box = video.getBoundingClientRect();
  const point = {
    x: Math.floor((event.clientX - box.left - left) / scale),
    y: Math.floor((event.clientY - box.top - top) / scale),
  };
  points = points.length === 2 ? [point] : [...points, point];
  draw();
  const distance = points.length === 2 ? distance_mm(points) : undefined;
  byId("distance").textContent =
    distance === undefined
      ? "click the second point"
      : distance === null
        ? "not in a perspective view"
        : `${distance.toFixed(1)} mm in the plane of the picture`;
});
addEventListener("resize", draw);

/** For tests. */
globalThis.relay = { shown_ages, shown: () => shown, peer: () => stream.peer };
