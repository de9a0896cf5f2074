// SPDX-License-Identifier: Apache-2.0
// Pages of another site that embed the page, show the pictures, call the API and open the stream: refused by default,
// and allowed by `serve --allow-origin`.
//   FANLIGHT_BIN           the fanlight binary (required)
//   FANLIGHT_ARTIFACTS     a folder for screenshots
//   CHROMIUM               the browser, if not /usr/bin/chromium
import assert from "node:assert/strict";
import { once } from "node:events";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { ServerProcess } from "./server_process.mjs";
import { launchChromium, until } from "./viewer_page.mjs";

const kSource = "phantom:scene=relief,probe=r1,frames=18,rate=60,speckle=off";

const host = (server) => `<!doctype html><title>another site</title>
  <iframe src="${server}" width="600" height="400"></iframe>
  <img id="jpeg" src="${server}api/picture.jpg?size=200x200">
  <img id="stream" src="${server}api/stream.mjpeg?size=200x200" crossorigin="anonymous">`;

let browser;
let site; // of another origin, and another host
let html = "";

before(async () => {
  browser = await launchChromium();
  site = createServer((_, response) => response.setHeader("Content-Type", "text/html").end(html));
  site.listen(0, "127.0.0.1");
  await once(site, "listening");
});

after(async () => {
  site.close();
  await browser.close();
});

const origin = () => `http://localhost:${site.address().port}`;

/** Calls `steps` with a page of the other site and the server. */
async function withEmbedded(name, options, steps) {
  const server = await ServerProcess.start(kSource, 0, options);
  try {
    html = host(server.url);
    const page = await browser.newPage();
    await page.goto(origin());
    await steps(page, server);
    if (process.env.FANLIGHT_ARTIFACTS) {
      await page.screenshot({ path: join(process.env.FANLIGHT_ARTIFACTS, `${name}.png`) });
    }
    await page.close();
  } finally {
    await server.end();
  }
}

/** The status of a request from the page, or "refused" where the browser hides the answer. */
function statusOf(page, url, options = {}) {
  return page.evaluate(
    ([address, init]) =>
      fetch(address, init).then(
        (response) => response.status,
        () => "refused",
      ),
    [url, options],
  );
}

const kChange = { method: "PATCH", headers: { "Content-Type": "application/json" }, body: '{"light": {"up_mm": 21}}' };

/** "open" or "refused". */
function streamOf(page, server) {
  return page.evaluate(
    (address) => {
      const socket = new WebSocket(address, "fanlight.v2");
      return new Promise((resolve) => {
        socket.onmessage = () => resolve("open");
        socket.onerror = () => resolve("refused");
      });
    },
    `${server.url.replace("http", "ws")}stream`,
  );
}

const widthOf = (page, id) => page.evaluate((name) => document.getElementById(name).naturalWidth, id);

/** Grey levels of the first pixels of what an <img> shows; throws where the page may not read them. */
function pixelsOf(page, id) {
  return page.evaluate((name) => {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 200;
    const context = canvas.getContext("2d");
    context.drawImage(document.getElementById(name), 0, 0);
    return [...context.getImageData(60, 60, 80, 80).data];
  }, id);
}

test("by default a page of another site gets nothing", async () => {
  await withEmbedded("embed_refused", [], async (page, server) => {
    for (const path of ["", "api/scene", "healthz"]) assert.equal(await statusOf(page, server.url + path), "refused");
    assert.equal(await statusOf(page, `${server.url}api/scene`, kChange), "refused");
    assert.equal(await streamOf(page, server), "refused");
    await page.waitForTimeout(1000);
    assert.equal(await widthOf(page, "jpeg"), 0);
    assert.equal(await widthOf(page, "stream"), 0);
    assert.ok(!(await page.frames()[1].url()).startsWith(server.url), "the frame shows the page");
    const { scene } = await (await fetch(`${server.url}api/scene`)).json();
    assert.notEqual(scene.light.up_mm, 21, "the change was not carried out");
  });
});

test("--allow-origin lets a page embed the page, show the pictures, call the API and open the stream", async () => {
  const options = ["--allow-origin", `https://other.example,${origin()}`];
  await withEmbedded("embed_allowed", options, async (page, server) => {
    assert.equal(await statusOf(page, `${server.url}api/scene`), 200);
    assert.equal(await statusOf(page, `${server.url}api/scene`, kChange), 200, "after a preflight request");
    assert.equal(await statusOf(page, `${server.url}api/nothing`), 404, "a refusal can be read");
    assert.equal(await streamOf(page, server), "open");
    await until(
      "the JPEG",
      () => widthOf(page, "jpeg"),
      (width) => width === 200,
    );
    await until(
      "the stream",
      () => widthOf(page, "stream"),
      (width) => width === 200,
    );
    const frame = page.frames()[1];
    assert.ok(frame.url().startsWith(server.url));
    await until("a picture in the frame", () => frame.locator("#picture").isVisible(), Boolean);
    // The stream follows the scene.
    const pixels = await pixelsOf(page, "stream");
    await statusOf(page, `${server.url}api/scene`, { ...kChange, body: '{"camera": {"yaw_deg": 40}}' });
    await until(
      "another picture of the stream",
      () => pixelsOf(page, "stream"),
      (now) => now.reduce((sum, value, index) => sum + Math.abs(value - pixels[index]), 0) / now.length > 4,
    );
  });
});

test("an origin that is not in the list gets nothing", async () => {
  await withEmbedded("embed_other", ["--allow-origin", "https://other.example"], async (page, server) => {
    assert.equal(await statusOf(page, `${server.url}api/scene`), "refused");
    assert.equal(await streamOf(page, server), "refused");
    await page.waitForTimeout(1000);
    assert.equal(await widthOf(page, "jpeg"), 0);
    assert.ok(!(await page.frames()[1].url()).startsWith(server.url));
  });
});
