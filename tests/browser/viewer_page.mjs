// SPDX-License-Identifier: Apache-2.0
// Drives the viewer page in Chromium and reads its state.
import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { setTimeout as pause } from "node:timers/promises";
import { chromium } from "playwright-core";

const kWaitMs = 120_000; // machines are shared

export const kViewport = { width: 1280, height: 800 }; // pixels

/**
 * `webGl`: on the processor, by SwiftShader; else the page shows the server's pictures. `compositor`: "processor" as where
 * Chromium finds no GPU, else SwiftShader draws the page too.
 */
export function launchChromium({ webGl = false, compositor = webGl ? "SwiftShader" : "processor" } = {}) {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: [
      "--headless",
      "--no-sandbox",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      ...(compositor === "processor" ? ["--disable-gpu"] : ["--use-gl=angle", "--use-angle=swiftshader"]),
      ...(webGl ? ["--enable-unsafe-swiftshader"] : ["--disable-3d-apis"]),
    ],
  });
}

/**
 * Polls `read` every 50 ms until `accept` returns true for its value, and returns the value. Fails after kWaitMs; the
 * error contains `expectation` and the last value.
 */
export async function until(expectation, read, accept) {
  const deadline_ms = performance.now() + kWaitMs;
  for (;;) {
    const value = await read();
    if (accept(value)) return value;
    if (performance.now() > deadline_ms) {
      throw new Error(`waited ${kWaitMs / 1000} s for: ${expectation}; last value: ${JSON.stringify(value)}`);
    }
    await pause(50);
  }
}

/** Where an element is on the page, once it is there: what lies over the picture is replaced with each picture. */
export function placeOf(locator) {
  return until(
    "the place of an element",
    () => locator.boundingBox(),
    (place) => place !== null,
  );
}

export class ViewerPage {
  consoleProblems = []; // errors and warnings of the console, and uncaught errors
  requestedUrls = []; // of all HTTP requests and WebSockets

  /** `browser`, for a session of its own, or a context of it, whose pages share a cache and load sooner. */
  static async open(browser, url) {
    const viewer = new ViewerPage();
    viewer.page = await browser.newPage(browser.newContext ? { viewport: kViewport } : {});
    viewer.page.setDefaultTimeout(kWaitMs);
    viewer.page.on("console", (message) => {
      if (message.type() === "error" || message.type() === "warning") viewer.consoleProblems.push(message.text());
    });
    viewer.page.on("pageerror", (error) => viewer.consoleProblems.push(String(error)));
    viewer.page.on("request", (request) => viewer.requestedUrls.push(request.url()));
    viewer.page.on("websocket", (socket) => viewer.requestedUrls.push(socket.url()));
    await viewer.page.goto(url);
    // Nearly all fields lie there.
    await viewer.page.locator("#advanced > summary").click();
    return viewer;
  }

  /** The text of an entry of the status line. */
  stat(name) {
    return this.page.locator(`[data-stat="${name}"]`).textContent();
  }

  /** The number in an entry of the status line; NaN while the page shows none. */
  async number(name) {
    return Number(await this.stat(name));
  }

  /** The value of a number field. */
  async field(name) {
    return Number(await this.page.locator(`[data-number="${name}"]`).inputValue());
  }

  /** The value of a text field. */
  text(name) {
    return this.page.locator(`[data-text="${name}"]`).inputValue();
  }

  /** Selects an option of a choice field by its visible label. */
  async choose(name, label) {
    await this.page.locator(`[data-field="${name}"]`).selectOption({ label });
  }

  /** Opens a group of settings if it is closed. */
  async unfold(group) {
    const details = this.page.locator(`[data-group="${group}"]`);
    if ((await details.getAttribute("open")) === null) await details.locator("summary").first().click();
  }

  /** Whether the title of the group contains "unused": its settings have no effect at present. */
  async unused(group) {
    return (await this.page.locator(`[data-group="${group}"] > summary`).textContent()).includes("unused");
  }

  /** State of the connection, such as "open" or "lost". */
  connection() {
    return this.page.locator("html").getAttribute("data-connection");
  }

  /** Waits for the first picture and returns its id. */
  firstPicture() {
    return until(
      "a first picture",
      () => this.number("picture-id"),
      (id) => id >= 1,
    );
  }

  /** Waits until the picture shown contains every change made so far. */
  settled() {
    return until(
      "a picture of the newest scene",
      () => this.page.locator("#picture").getAttribute("aria-busy"),
      (busy) => busy === "false",
    );
  }

  /** [red, green, blue] of every fourth pixel, in both directions, of the middle half of the picture; 0 to 255. */
  colours() {
    return this.page.locator("#picture").evaluate((canvas) => {
      const [width, height] = [canvas.width >> 1, canvas.height >> 1];
      const copy = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
      copy.drawImage(canvas, -(canvas.width >> 2), -(canvas.height >> 2));
      const { data } = copy.getImageData(0, 0, width, height);
      const colours = [];
      for (let row = 0; row < height; row += 4) {
        for (let column = 0; column < width; column += 4) {
          const at = (row * width + column) * 4;
          colours.push([data[at], data[at + 1], data[at + 2]]);
        }
      }
      return colours;
    });
  }

  /** Grey levels (mean of the channels, 0 to 255) of the pixels of colours(). */
  async greyLevels() {
    return (await this.colours()).map(([red, green, blue]) => (red + green + blue) / 3);
  }

  /**
   * Waits until the picture differs from one of greyLevels() by more than `least`, as difference() counts. For a change
   * that the page may not have sent yet, when settled() would find the old picture.
   */
  changedFrom(before, least, cause) {
    return until(
      `a picture that ${cause} has changed`,
      async () => difference(before, await this.greyLevels()),
      (by) => by > least,
    );
  }

  /** Waits until the picture differs from one of greyLevels() by less than `most`, as difference() counts. */
  becomes(picture, most, name) {
    return until(
      name,
      async () => difference(picture, await this.greyLevels()),
      (by) => by < most,
    );
  }

  /** Mean of red minus blue over the pixels of colours(), -255 to 255. */
  async redMinusBlue() {
    const colours = await this.colours();
    return colours.reduce((sum, [red, , blue]) => sum + red - blue, 0) / colours.length;
  }

  /** Centre of the light marker, [x, y] as fractions of the picture's width and height; null while it is hidden. */
  async lightMarker() {
    const light = await this.page.locator("[data-lamp=light]").boundingBox();
    const picture = await this.page.locator("#picture").boundingBox();
    return (
      light && [
        (light.x + light.width / 2 - picture.x) / picture.width,
        (light.y + light.height / 2 - picture.y) / picture.height,
      ]
    );
  }

  /** Drags the mouse over the picture. `from` and `to`: [x, y] as fractions of its width and height. */
  async drag(from, to, button = "left") {
    const box = await this.page.locator("#picture").boundingBox();
    const at = ([x, y]) => [box.x + x * box.width, box.y + y * box.height];
    await this.page.mouse.move(...at(from));
    await this.page.mouse.down({ button });
    await this.page.mouse.move(...at(to), { steps: 12 });
    await this.page.mouse.up({ button });
  }

  /** Saves NAME.png in the folder FANLIGHT_ARTIFACTS; does nothing where the variable is not set. */
  async screenshot(name) {
    const folder = process.env.FANLIGHT_ARTIFACTS;
    if (!folder) return;
    await mkdir(folder, { recursive: true });
    await this.page.screenshot({ path: join(folder, `${name}.png`) });
  }
}

/** Mean absolute difference of two results of greyLevels(); Infinity where the lengths differ or are 0. */
export function difference(before, after) {
  if (before.length !== after.length || before.length === 0) return Infinity;
  return before.reduce((sum, level, index) => sum + Math.abs(level - after[index]), 0) / before.length;
}
