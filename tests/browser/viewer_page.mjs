// The page in a real Chromium, as the tests see it.
import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { setTimeout as pause } from "node:timers/promises";
import { chromium } from "playwright-core";

const kWaitMs = 30_000;

export function launchChromium() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: [
      "--headless",
      "--no-sandbox",
      "--disable-gpu",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
    ],
  });
}

/** Asks until the answer is accepted, and returns it; fails with the last answer. */
export async function until(what, ask, accept) {
  const deadline_ms = performance.now() + kWaitMs;
  for (;;) {
    const answer = await ask();
    if (accept(answer)) return answer;
    if (performance.now() > deadline_ms) {
      throw new Error(`waited ${kWaitMs / 1000} s for: ${what}; last seen: ${JSON.stringify(answer)}`);
    }
    await pause(50);
  }
}

export class ViewerPage {
  complaints = []; // what the console and uncaught errors said
  addresses = []; // everything that was requested

  static async open(browser, url) {
    const viewer = new ViewerPage();
    viewer.page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
    viewer.page.setDefaultTimeout(kWaitMs);
    viewer.page.on("console", (message) => {
      if (message.type() === "error" || message.type() === "warning") viewer.complaints.push(message.text());
    });
    viewer.page.on("pageerror", (error) => viewer.complaints.push(String(error)));
    viewer.page.on("request", (request) => viewer.addresses.push(request.url()));
    viewer.page.on("websocket", (socket) => viewer.addresses.push(socket.url()));
    await viewer.page.goto(url);
    return viewer;
  }

  stat(name) {
    return this.page.locator(`[data-stat="${name}"]`).textContent();
  }

  async number(name) {
    return Number(await this.stat(name)); // NaN while the page has none
  }

  async field(name) {
    return Number(await this.page.locator(`[data-number="${name}"]`).inputValue());
  }

  /** The text of a text field. */
  text(name) {
    return this.page.locator(`[data-text="${name}"]`).inputValue();
  }

  /** Of a field that is a choice; `label` is what a person reads. */
  async choose(name, label) {
    await this.page.locator(`[data-field="${name}"]`).selectOption({ label });
  }

  /** Unfolds a group of settings. */
  async unfold(group) {
    const details = this.page.locator(`[data-group="${group}"]`);
    if ((await details.getAttribute("open")) === null) await details.locator("summary").first().click();
  }

  /** Whether the page says that this group has no effect. */
  async unused(group) {
    return (await this.page.locator(`[data-group="${group}"] > summary`).textContent()).includes("unused");
  }

  connection() {
    return this.page.locator("html").getAttribute("data-connection");
  }

  firstPicture() {
    return until(
      "a first picture",
      () => this.number("picture-id"),
      (id) => id >= 1,
    );
  }

  /** The picture shown is the one of every change made so far. */
  settled() {
    return until(
      "a picture of the newest scene",
      () => this.page.locator("#picture").getAttribute("aria-busy"),
      (busy) => busy === "false",
    );
  }

  /** Red, green and blue of the picture's middle half, every fourth pixel each way. */
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

  /** Grey levels of the same pixels. */
  async grey() {
    return (await this.colours()).map(([red, green, blue]) => (red + green + blue) / 3);
  }

  /** How much more red than blue the same pixels have, on average, in levels of 255. */
  async warmth() {
    const colours = await this.colours();
    return colours.reduce((sum, [red, , blue]) => sum + red - blue, 0) / colours.length;
  }

  /** The light's marker as fractions of the picture's width and height; nothing where it is not shown. */
  async marker() {
    const light = await this.page.locator("#light").boundingBox();
    const picture = await this.page.locator("#picture").boundingBox();
    return (
      light && [
        (light.x + light.width / 2 - picture.x) / picture.width,
        (light.y + light.height / 2 - picture.y) / picture.height,
      ]
    );
  }

  /** From and to as fractions of the picture's width and height. */
  async drag(from, to, button = "left") {
    const box = await this.page.locator("#picture").boundingBox();
    const at = ([x, y]) => [box.x + x * box.width, box.y + y * box.height];
    await this.page.mouse.move(...at(from));
    await this.page.mouse.down({ button });
    await this.page.mouse.move(...at(to), { steps: 12 });
    await this.page.mouse.up({ button });
  }

  async screenshot(name) {
    const folder = process.env.FANLIGHT_ARTIFACTS;
    if (!folder) return;
    await mkdir(folder, { recursive: true });
    await this.page.screenshot({ path: join(folder, `${name}.png`) });
  }
}

/** Mean absolute difference of two grey() answers. */
export function difference(before, after) {
  if (before.length !== after.length || before.length === 0) return Infinity;
  return before.reduce((sum, level, index) => sum + Math.abs(level - after[index]), 0) / before.length;
}
