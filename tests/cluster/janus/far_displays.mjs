// SPDX-License-Identifier: Apache-2.0
// What tests/cluster/janus/run measures and checks. Environment: CHROMIUM, FANLIGHT_BIN, WORK, NAMESPACE, DEPLOY.
import { execFileSync, spawn, spawnSync } from "node:child_process";
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { randomBytes } from "node:crypto";
import { extname, join } from "node:path";
import { setTimeout as pause } from "node:timers/promises";
import { ServerProcess } from "./server_process.mjs";
import { launchChromium, until } from "./viewer_page.mjs";

const { WORK, NAMESPACE, DEPLOY } = process.env;
const ADDRESS = "10.77.0.1";
const JANUS = `ws://${ADDRESS}:8188`;
const SOURCE = "phantom:scene=relief,probe=r1,columns=128,rows=192,frames=24,rate=480";
const KEY = randomBytes(30).toString("base64");

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)] ?? NaN;
const percentile = (values, share) =>
  [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(values.length * share))] ?? NaN;
const ms = (seconds) => `${(1000 * seconds).toFixed(0)} ms`;
const tell = (line) => console.log(`janus: ${line}`);
const fail = (sentence) => {
  throw new Error(sentence);
};

// ---- Janus
function configureJanus(extra) {
  const folder = join(WORK, "janus");
  mkdirSync(folder, { recursive: true });
  writeFileSync(
    join(folder, "janus.jcfg"),
    `general: { debug_level = 4, admin_secret = "${randomBytes(8).toString("hex")}" }
nat: { ice_enforce_list = "${ADDRESS}" }
plugins: { disable = "libjanus_audiobridge.so,libjanus_duktape.so,libjanus_echotest.so,libjanus_lua.so,libjanus_nosip.so,libjanus_recordplay.so,libjanus_sip.so,libjanus_textroom.so,libjanus_videocall.so,libjanus_videoroom.so,libjanus_voicemail.so" }
transports: { disable = "libjanus_http.so,libjanus_mqtt.so,libjanus_nanomsg.so,libjanus_pfunix.so,libjanus_rabbitmq.so" }
`,
  );
  writeFileSync(
    join(folder, "janus.transport.websockets.jcfg"),
    `general: { ws = true, ws_port = 8188, ws_ip = "${ADDRESS}", wss = false }\nadmin: { admin_ws = false }\n`,
  );
  // What deploy/janus has, with the key of this run.
  let room = readFileSync(join(DEPLOY, "janus.plugin.streaming.jcfg"), "utf8");
  if (extra) {
    room = room.replace("# srtpsuite = 80", "srtpsuite = 80").replace('# srtpcrypto = "..."', `srtpcrypto = "${KEY}"`);
    if (!room.includes(KEY)) fail("the configuration of Janus has no place for a key");
  }
  writeFileSync(join(folder, "janus.plugin.streaming.jcfg"), room);
  return folder;
}

function startJanus(folder) {
  const log = join(WORK, "janus.log");
  const janus = spawn("sh", ["-c", `exec janus --configs-folder="${folder}" >>"${log}" 2>&1`], { stdio: "ignore" });
  return janus;
}

async function end(process, signal = "SIGTERM") {
  if (process.exitCode !== null || process.signalCode !== null) return;
  const ended = new Promise((resolve) => process.once("exit", resolve));
  process.kill(signal);
  await ended;
}

// ---- The page's files
const KINDS = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css" };
const pages = createServer((request, response) => {
  const name = new URL(request.url, "http://x").pathname.slice(1);
  try {
    const bytes = readFileSync(join(DEPLOY, "page", name.replaceAll("/", "")));
    response.writeHead(200, { "content-type": KINDS[extname(name)] ?? "text/plain" }).end(bytes);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((resolve) => pages.listen(0, ADDRESS, resolve));
const PAGE = `http://${ADDRESS}:${pages.address().port}/index.html?janus=${encodeURIComponent(JANUS)}&mountpoint=1`;

// ---- Losses, in the browsers' namespace
const nft = (...words) => execFileSync("ip", ["netns", "exec", NAMESPACE, "nft", words.join(" ")]);
function loseOnTheWay(percent) {
  // The kernel here may lack netem; nft drops packets at random as well.
  nft("add table inet loss");
  for (const hook of ["input", "output"]) {
    nft(`add chain inet loss ${hook} { type filter hook ${hook} priority 0; }`);
    nft(`add rule inet loss ${hook} meta l4proto udp numgen random mod 100 < ${percent} counter drop`);
  }
}
const loseNothing = () => nft("delete table inet loss");

// ---- Displays
async function openDisplay() {
  const browser = await launchChromium();
  const page = await browser.newPage({ viewport: { width: 720, height: 800 } });
  page.on("pageerror", (error) => tell(`the page: ${error}`));
  await page.goto(PAGE);
  return { browser, page };
}
const text = (display, id) => display.page.locator(`#${id}`).textContent();
const ages = (display) => display.page.evaluate(() => globalThis.relay.shown_ages.splice(0));
const live = (display, what) =>
  until(
    `${what}: a far display is live`,
    () => text(display, "state"),
    (state) => state === "Live",
  );
const videoStats = (display) =>
  display.page.evaluate(async () => {
    const report = await globalThis.relay.peer()?.getStats();
    return [...(report?.values() ?? [])].find((entry) => entry.type === "inbound-rtp") ?? {};
  });

/** Ages of the pictures of all displays over this many seconds. */
async function watch(displays, seconds, what) {
  for (const display of displays) await ages(display);
  const before = await Promise.all(displays.map(videoStats));
  await pause(1000 * seconds);
  const all = (await Promise.all(displays.map(ages))).flat();
  const after = await Promise.all(displays.map(videoStats));
  const sum = (name) => after.reduce((total, stats, i) => total + ((stats[name] ?? 0) - (before[i][name] ?? 0)), 0);
  if (all.length < displays.length * seconds)
    fail(`${what}: ${all.length} pictures in ${seconds} s on ${displays.length}`);
  tell(
    `${what}: age ${ms(median(all.map((each) => each.age_s)))}, p95 ${ms(
      percentile(
        all.map((each) => each.age_s),
        0.95,
      ),
    )}, ` +
      `of which since it was sent ${ms(median(all.map((each) => each.travel_s)))}, ` +
      `${(all.length / displays.length / seconds).toFixed(1)} pictures/s a display; of ` +
      `${sum("packetsReceived")} packets ${sum("packetsLost")} were lost on the way, ${sum("nackCount")} asked for again; ` +
      `${sum("pliCount")} key pictures asked for, ${sum("freezeCount")} freezes of ${sum("totalFreezesDuration").toFixed(1)} s`,
  );
  return all;
}

// ---- Fanlight
async function metric(server, name) {
  const page = await (await fetch(`${server.url}metrics`)).text();
  const line = page.split("\n").find((each) => each.startsWith(`fanlight_${name}_total `));
  return Number(line.split(" ")[1]);
}
/** Processor seconds so far: of the process, or of its server thread, which sends and neither renders nor encodes. */
function processorSeconds(pid, file = "stat") {
  const fields = readFileSync(`/proc/${pid}/${file}`, "utf8").split(") ")[1].split(" ");
  return (Number(fields[11]) + Number(fields[12])) / 100;
}
async function costOfAPicture(server, seconds) {
  const pictures = await metric(server, "rtp_pictures_sent");
  const thread = `task/${server.pid}/stat`;
  const begin_s = processorSeconds(server.pid);
  const thread_begin_s = processorSeconds(server.pid, thread);
  await pause(1000 * seconds);
  const sent = (await metric(server, "rtp_pictures_sent")) - pictures;
  return {
    ms: (1000 * (processorSeconds(server.pid) - begin_s)) / sent,
    thread_ms: (1000 * (processorSeconds(server.pid, thread) - thread_begin_s)) / sent,
    sent,
  };
}

// ---- Players of others
function play(name, command, args, output) {
  const played = spawnSync(command, args, { timeout: 60_000, encoding: "utf8", cwd: WORK });
  const frames = output(played);
  if (!(frames >= 10)) fail(`${name} played ${frames} pictures: ${played.stderr.slice(-2000)}`);
  tell(`${name} played ${frames} pictures`);
}
async function playElsewhere(encrypted) {
  const sdp = join(WORK, `players-${encrypted}.sdp`);
  const key = join(WORK, "key");
  const server = await ServerProcess.start(SOURCE, 0, [
    ...["--size", "256x256", "--rtp-to", "127.0.0.1:5104", "--rtp-start", "--rtp-sdp", sdp],
    ...(encrypted ? ["--rtp-key", key] : []),
  ]);
  try {
    await until(
      "the description of the stream",
      () => spawnSync("test", ["-s", sdp]).status,
      (status) => status === 0,
    );
    const kind = encrypted ? "SRTP" : "RTP";
    copyFileSync(sdp, join(WORK, "x.sdp"));
    play(
      `FFmpeg (${kind})`,
      "ffmpeg",
      "-hide_banner -loglevel info -protocol_whitelist file,rtp,udp -i x.sdp -frames:v 20 -f null -".split(" "),
      (played) => Number(played.stderr.match(/frame= *(\d+)(?!.*frame=)/s)?.[1] ?? 0),
    );
    if (encrypted) return;
    play(
      "GStreamer (RTP)",
      "gst-launch-1.0",
      [
        ...[
          "udpsrc",
          "port=5104",
          "num-buffers=400",
          "caps=application/x-rtp,media=video,clock-rate=90000,encoding-name=H264",
        ],
        ...["!", "rtpjitterbuffer", "!", "rtph264depay", "!", "avdec_h264", "!", "videoconvert", "!", "pngenc"],
        ...["!", "multifilesink", "location=gst-%d.png"],
      ],
      () => spawnSync("sh", ["-c", "ls gst-*.png | wc -l"], { cwd: WORK, encoding: "utf8" }).stdout.trim(),
    );
  } finally {
    await server.end();
  }
}

writeFileSync(join(WORK, "key"), `${KEY}\n`, { mode: 0o600 });
await playElsewhere(false);
await playElsewhere(true);

const folder = configureJanus(true);
let janus = startJanus(folder);
const server = await ServerProcess.start(SOURCE, 0, [
  ...["--size", "256x256", "--title", "Room 1", "--rtp-to", "127.0.0.1:5004", "--rtp-start", "--rtp-kbps", "2000"],
  ...["--rtp-key", join(WORK, "key")],
]);
const displays = [];
try {
  for (let i = 0; i < 3; ++i) displays.push(await openDisplay());
  for (const display of displays) await live(display, "at first");
  if ((await text(displays[0], "title")) !== "Room 1") fail("a far display does not show the title");
  await watch(displays, 20, "without loss");
  await displays[0].page.screenshot({ path: join(WORK, "far.png") });
  if (process.env.PICTURE) copyFileSync(join(WORK, "far.png"), process.env.PICTURE);

  loseOnTheWay(5);
  await watch(displays, 20, "with 5 % of all packets lost, both ways");
  loseNothing();
  const healed_ms = performance.now();
  for (const display of displays) await live(display, "after the loss");
  await watch(displays, 5, `${ms((performance.now() - healed_ms) / 1000)} after the losses have ended`);

  await end(janus, "SIGKILL");
  for (const display of displays) {
    const state = await until(
      "a killed Janus is reported",
      () => text(display, "state"),
      (now) => now !== "Live",
    );
    if (state !== "Not live") fail(`a killed Janus is reported as ${state}`);
  }
  tell(`a killed Janus: "${await text(displays[0], "sentence")}"`);
  janus = startJanus(folder);
  const back_ms = performance.now();
  for (const display of displays) await live(display, "after Janus is back");
  tell(`Janus is back: all three displays are live ${ms((performance.now() - back_ms) / 1000)} after its start`);
  if ((await metric(server, "rtp_keys_requested")) < 1) fail("Janus asked for no key picture");

  // One and a hundred viewers: connections without a decoder's window, on one page.
  for (const display of displays.splice(1)) await display.browser.close();
  await pause(3000);
  const one = await costOfAPicture(server, 20);
  const [display] = displays;
  const many = await display.page.evaluate(async (janus) => {
    const { JanusStream } = await import("./janus_stream.js");
    globalThis.counts = Array(99).fill(0);
    globalThis.crowd = globalThis.counts.map(
      (_, i) =>
        new JanusStream({
          url: janus,
          mountpoint: 1,
          onstream() {},
          onstate() {},
          ondata: () => ++globalThis.counts[i],
        }),
    );
    await new Promise((resolve) => setTimeout(resolve, 25_000));
    globalThis.counts.fill(0);
    return globalThis.crowd.length + 1;
  }, JANUS);
  const hundred = await costOfAPicture(server, 20);
  const served = await display.page.evaluate(() => globalThis.counts.filter((count) => count > 0).length + 1);
  tell(
    `processor time of Fanlight a picture: ${one.ms.toFixed(0)} ms with one viewer, ${hundred.ms.toFixed(0)} ms with ` +
      `${many}; of its server thread, which sends: ${one.thread_ms.toFixed(2)} and ${hundred.thread_ms.toFixed(2)} ms ` +
      `(${one.sent} and ${hundred.sent} pictures); ${served} of the ${many} got pictures`,
  );
  if (served < 90) fail(`${served} of ${many} viewers got pictures`);
  if (one.sent < 10 || hundred.sent < 10) fail("Fanlight sent few pictures");
} catch (failure) {
  console.error(server.output.slice(-3000));
  console.error(spawnSync("tail", ["-n", "30", join(WORK, "janus.log")], { encoding: "utf8" }).stdout);
  throw failure;
} finally {
  for (const display of displays) await display.browser.close().catch(() => {});
  await server.end().catch(() => {});
  await end(janus).catch(() => {});
  pages.close();
}
