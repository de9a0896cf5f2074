// SPDX-License-Identifier: Apache-2.0
// Measures how long an input takes to the picture that holds it, on the default source, in Chromium beside the server
// on one machine: `tests/run latency`; or, with --growth, what page and server take of memory over five minutes.
// Prints its figures and asserts nothing, since a shared machine is noisy.
import { readFileSync } from "node:fs";
import { setTimeout as pause } from "node:timers/promises";
import { ServerProcess } from "./server_process.mjs";
import { launchChromium } from "./viewer_page.mjs";

const kInputs = 20;
const kSource = process.env.FANLIGHT_LATENCY_SOURCE ?? "phantom:scene=relief,probe=r1";

const median = (numbers) => [...numbers].sort((a, b) => a - b)[Math.floor(numbers.length / 2)];

/** Runs in the page: makes the input, and waits for the picture that shows it. */
function inputToPicture(input) {
  const canvas = document.querySelector("#picture");
  return new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`no picture for ${JSON.stringify(input)}`)), 20_000);
    const from = performance.now();
    const observer = new MutationObserver(() => {
      if (canvas.ariaBusy !== "false") return;
      observer.disconnect();
      clearTimeout(timer);
      resolve(performance.now() - from);
    });
    observer.observe(canvas, { attributes: true, attributeFilter: ["aria-busy"] });
    if (input.key) canvas.dispatchEvent(new KeyboardEvent("keydown", { key: input.key, bubbles: true }));
    if (input.slider) {
      const slider = document.querySelector(`[data-quick="${input.slider}"]`);
      slider.value = String(input.value);
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }
    if (input.layout) document.querySelector(`#layout input[value="${input.layout}"]`).click();
  });
}

const kActions = {
  light: { tool: "light", input: (n) => ({ key: n % 2 ? "ArrowLeft" : "ArrowRight" }) },
  turn: { tool: "orbit", input: (n) => ({ key: n % 2 ? "ArrowLeft" : "ArrowRight" }) },
  threshold: { tool: "light", input: (n) => ({ slider: "detector.threshold", value: 30 + n }) },
  mode: { tool: "light", input: (n) => ({ layout: n % 2 ? "surface" : "slices" }) },
};

async function firstPictureMs(browser, url) {
  const page = await browser.newPage();
  const from = performance.now();
  await page.goto(url);
  await page.locator("#frame").waitFor({ state: "visible" });
  const ms = performance.now() - from;
  await page.close();
  return ms;
}

/** The page is in use all the time: the light moves. */
async function tellGrowth(browser, server) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await page.goto(server.url);
  await page.locator("#frame").waitFor({ state: "visible" });
  const session = await page.context().newCDPSession(page);
  for (let minute = 0; minute <= 5; ++minute) {
    for (let second = 0; minute > 0 && second < 60; ++second) {
      await page.locator("#picture").press(second % 2 ? "ArrowLeft" : "ArrowRight");
      await pause(1000);
    }
    await session.send("HeapProfiler.collectGarbage");
    const { usedSize } = await session.send("Runtime.getHeapUsage");
    const resident = /VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${server.pid}/status`, "utf8"))[1];
    console.log(
      `${minute} min: page ${(usedSize / 1e6).toFixed(1)} MB of scripts, server ${(resident / 1e3).toFixed(0)} MB`,
    );
  }
}

const server = await ServerProcess.start(kSource, 0, []);
const browser = await launchChromium();
if (process.argv.includes("--growth")) {
  await tellGrowth(browser, server);
  await browser.close();
  await server.end();
  process.exit();
}
try {
  const warm = await browser.newPage();
  await warm.goto(server.url);
  await warm.locator("#frame").waitFor({ state: "visible" });
  await pause(3000);
  await warm.close();
  const watched = [];
  for (let visit = 0; visit < 5; ++visit) watched.push(await firstPictureMs(browser, server.url));
  await pause(12_000); // the server renders nothing now
  const resting = await firstPictureMs(browser, server.url);
  console.log(`first picture: median ${median(watched).toFixed(0)} ms; after a rest ${resting.toFixed(0)} ms`);
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  await page.goto(server.url);
  await page.locator("#frame").waitFor({ state: "visible" });
  await pause(2000);
  for (const [name, { tool, input }] of Object.entries(kActions)) {
    await page.locator(`#tools input[value="${tool}"]`).evaluate((radio) => radio.click());
    const times = [];
    for (let n = 0; n < kInputs + 2; ++n) {
      const ms = await page.evaluate(inputToPicture, input(n));
      if (n >= 2) times.push(ms); // the first ones build pipelines
      await pause(300 + Math.random() * 500); // at any moment of a volume
    }
    times.sort((a, b) => a - b);
    const at = (share) => times[Math.floor(share * (times.length - 1))].toFixed(0);
    console.log(`${name}: median ${median(times).toFixed(0)} ms (${at(0.1)} to ${at(0.9)}, 10 to 90 %)`);
  }
} finally {
  await browser.close();
  await server.end();
}
