// SPDX-License-Identifier: Apache-2.0
// Measures what a hand sees while it drags the light, turns the surface and steps through frozen volumes, in Chromium
// without a GPU beside the server on one machine: `tests/run drag`. Prints its figures and asserts nothing, since a
// shared machine is noisy.
//   pictures a second   how often the canvas of the picture is drawn during a drag of four seconds
//   input to pixel      from a single movement to the canvas that shows it drawn; medians of 20, frozen
//   cast                a picture for which the server has cast rays: how often one is shown while the hand turns
// `tests/run drag --pinned`: the server on one processor, the browser and this script on the other. `--load N`: beside
// that many processes that do nothing else than compute.
import { execFileSync, spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { setTimeout as pause } from "node:timers/promises";
import { ServerProcess } from "./server_process.mjs";
import { launchChromium } from "./viewer_page.mjs";

const kSource = process.env.FANLIGHT_LATENCY_SOURCE ?? "phantom:";
const kInputs = 20;
const kPinned = process.argv.includes("--pinned");
const kLoad = Number(process.argv[process.argv.indexOf("--load") + 1] ?? 0) || 0;
const kBrowsers = {
  "surfaces, lit by the page": { webGl: true, compositor: "processor" },
  "surfaces, and the page itself drawn by SwiftShader": { webGl: true },
  "pictures of the server": { webGl: false },
};

const median = (numbers) => [...numbers].sort((a, b) => a - b)[Math.floor(numbers.length / 2)] ?? NaN;

/** Runs in the page before its scripts: notes when the picture is drawn, and when one with another cast is shown. */
function watchCanvas() {
  window.drawnMs = [];
  window.castMs = [];
  document.addEventListener("DOMContentLoaded", () => {
    const casts = document.querySelector('[data-stat="pass1-runs"]');
    new MutationObserver(() => window.castMs.push(performance.now())).observe(casts, { childList: true });
  });
  const draw = CanvasRenderingContext2D.prototype.drawImage;
  CanvasRenderingContext2D.prototype.drawImage = function (...from) {
    draw.apply(this, from);
    // The layers of one picture come at once.
    const isNext = !(performance.now() - window.drawnMs.at(-1) < 4);
    if (this.canvas.id === "picture" && isNext) window.drawnMs.push(performance.now());
  };
}

/** Runs in the page: drags to and fro for some time, and returns when the picture was drawn. */
async function drag({ seconds }) {
  const canvas = document.querySelector("#picture");
  const { x, y, width, height } = canvas.getBoundingClientRect();
  canvas.setPointerCapture = () => {};
  const point = (type, right, down) =>
    canvas.dispatchEvent(
      new PointerEvent(type, {
        clientX: x + width * (0.5 + right),
        clientY: y + height * (0.5 + down),
        pointerId: 1,
        pointerType: "mouse",
        bubbles: true,
      }),
    );
  point("pointerdown", 0, 0);
  window.drawnMs.length = window.castMs.length = 0;
  const from = performance.now();
  await new Promise((resolve) => {
    const timer = setInterval(() => {
      const passed = (performance.now() - from) / 1000;
      if (passed > seconds) {
        clearInterval(timer);
        resolve();
      } else {
        point("pointermove", 0.2 * Math.sin(3 * passed), 0.14 * Math.sin(2.1 * passed));
      }
    }, 16);
  });
  point("pointerup", 0, 0);
  const during = (times) => times.filter((ms) => ms < from + 1000 * seconds);
  return { drawn: during(window.drawnMs), casts: [from, ...during(window.castMs), from + 1000 * seconds] };
}

/** Runs in the page: presses a key, and waits until the picture is drawn by it. */
function keyToPicture({ key, onBody }) {
  const target = onBody ? document.body : document.querySelector("#picture");
  window.drawnMs.length = 0;
  const from = performance.now();
  target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
  return new Promise((resolve) => {
    const timer = setInterval(() => {
      const [first] = window.drawnMs;
      if (first === undefined && performance.now() - from < 10_000) return;
      clearInterval(timer);
      resolve(first === undefined ? undefined : first - from);
    }, 2);
  });
}

async function tool(page, name) {
  await page.locator(`#tools input[value="${name}"]`).evaluate((radio) => radio.click());
}

/** Of all threads of the server until now. */
function processorS(pid) {
  const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
  return (Number(fields[11]) + Number(fields[12])) / 100;
}

async function sentBytes(url) {
  const metrics = await (await fetch(`${url}metrics`)).text();
  return Number(/^fanlight_picture_bytes_sent_total ([\d.e+]+)$/m.exec(metrics)?.[1] ?? NaN);
}

async function measureDrag(page, server, name) {
  const beganMs = performance.now();
  const began = processorS(server.pid);
  const { drawn, casts } = await page.evaluate(drag, { seconds: 4 });
  const share = (processorS(server.pid) - began) / ((performance.now() - beganMs) / 1000);
  const gapsOf = (times) => times.slice(1).map((ms, index) => ms - times[index]);
  const longest = (times) => Math.max(...gapsOf(times), 0).toFixed(0);
  console.log(
    `  ${name}: ${(drawn.length / 4).toFixed(1)} pictures a second, longest gap ${longest(drawn)} ms; ` +
      `${(casts.length - 2) / 4} casts a second, longest gap ${longest(casts)} ms; server ${share.toFixed(2)} of a processor`,
  );
}

/** What a viewer costs the server that moves a light of its own, beside one that moves nothing. */
async function measureOwnLight(page, server) {
  const shareWhile = async (act) => {
    const [beganMs, began] = [performance.now(), processorS(server.pid)];
    await act();
    return (processorS(server.pid) - began) / ((performance.now() - beganMs) / 1000);
  };
  await tool(page, "light");
  await page.locator("#own-view input").check();
  await pause(2000);
  const atRest = await shareWhile(() => pause(6000));
  const moved = await shareWhile(() => page.evaluate(drag, { seconds: 6 }));
  await page.locator("#own-view input").uncheck();
  await pause(1000);
  console.log(`  own light, frozen: server ${moved.toFixed(3)} of a processor, ${atRest.toFixed(3)} at rest`);
}

async function measureKeys(page, name, keys, onBody) {
  const times = [];
  for (let input = 0; input < kInputs; ++input) {
    const ms = await page.evaluate(keyToPicture, { key: keys[input % keys.length], onBody });
    if (ms !== undefined) times.push(ms);
    await pause(500 + 300 * Math.random());
  }
  const at = (share) => [...times].sort((a, b) => a - b)[Math.floor(share * (times.length - 1))]?.toFixed(0);
  console.log(`  ${name}: median ${median(times).toFixed(0)} ms (${at(0.1)} to ${at(0.9)}, 10 to 90 %)`);
}

async function measure(browser, server) {
  const firsts = [];
  for (let visit = 0; visit < 5; ++visit) {
    const page = await browser.newPage();
    const from = performance.now();
    await page.goto(server.url);
    await page.locator("#frame").waitFor({ state: "visible" });
    firsts.push(performance.now() - from);
    await page.close();
  }
  console.log(`  first picture: median ${median(firsts).toFixed(0)} ms`);
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await page.addInitScript(watchCanvas);
  await page.goto(server.url);
  await page.locator("#frame").waitFor({ state: "visible" });
  await pause(4000);
  const [bytes, fromMs] = [await sentBytes(server.url), performance.now()];
  await pause(8000);
  const bytesS = ((await sentBytes(server.url)) - bytes) / ((performance.now() - fromMs) / 1000);
  console.log(`  live, at rest: ${(bytesS / 1000).toFixed(0)} KB a second`);
  for (const [name, value] of Object.entries({ "light, live": "light", "turn, live": "orbit" })) {
    await tool(page, value);
    await measureDrag(page, server, name);
    await pause(2000);
  }
  await page.locator('[data-cine="freeze"]').click();
  await pause(2500);
  for (const [name, value] of Object.entries({ "light, frozen": "light", "turn, frozen": "orbit" })) {
    await tool(page, value);
    await measureDrag(page, server, name);
    await pause(2000);
  }
  await measureOwnLight(page, server);
  await tool(page, "light");
  await measureKeys(page, "light, input to pixel", ["ArrowRight", "ArrowLeft"], false);
  await tool(page, "orbit");
  await measureKeys(page, "turn, input to pixel", ["ArrowRight", "ArrowLeft"], false);
  for (const key of [",", ","]) {
    await page.evaluate(keyToPicture, { key, onBody: true });
    await pause(2500);
  }
  await measureKeys(page, "step to a volume seen before", [".", ","], true);
  await page.close();
}

const pin = (pid, processor) => execFileSync("taskset", ["-acp", String(processor), String(pid)], { stdio: "ignore" });
if (kPinned) pin(process.pid, 1); // and what it starts
const load = Array.from({ length: kLoad }, () => spawn(process.execPath, ["-e", "for (;;);"]));
// In those two the first one alone.
const browsers = Object.entries(kBrowsers).slice(0, kPinned || kLoad > 0 ? 1 : undefined);
for (const [name, options] of browsers) {
  const server = await ServerProcess.start(kSource, 0, []);
  const browser = await launchChromium(options);
  if (kPinned) pin(server.pid, 0);
  try {
    console.log(`${name}${kPinned ? ", pinned" : ""}${kLoad > 0 ? `, load ${kLoad}` : ""}`);
    await pause(3000);
    await measure(browser, server);
  } finally {
    await browser.close();
    await server.end();
  }
}
for (const each of load) each.kill("SIGKILL");
