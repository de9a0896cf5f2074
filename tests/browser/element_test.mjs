// SPDX-License-Identifier: Apache-2.0
// <fanlight-view> in a page of another site: what its README shows, in Chromium.
//   FANLIGHT_BIN           the fanlight binary (required)
//   FANLIGHT_ROOT          the source tree (required)
//   FANLIGHT_ELEMENT       the npm package of the element, as it was built (required)
//   FANLIGHT_ARTIFACTS     a folder for screenshots
//   CHROMIUM               the browser, if not /usr/bin/chromium
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { ServerProcess } from "./server_process.mjs";
import { launchChromium, until } from "./viewer_page.mjs";

const kSource = "phantom:scene=relief,probe=r1,frames=18,rate=60,speckle=off";
const kReadme = readFileSync(join(process.env.FANLIGHT_ROOT, "server/viewer/element/README.md"), "utf8");
// A policy as strict as a hospital's: no inline style, and scripts and connections to the server alone.
const policyFor = (server) =>
  `default-src 'none'; script-src ${server}; connect-src ${server} ${server.replace("http", "ws")}; style-src 'unsafe-inline'`;

let browser;
let site; // of another origin, and another host
let html = "";
let policy = "";

before(async () => {
  browser = await launchChromium();
  site = createServer((request, response) => {
    if (request.url !== "/") return response.writeHead(404).end();
    response.setHeader("Content-Security-Policy", policy);
    response.setHeader("Content-Type", "text/html").end(`<!doctype html><title>another site</title>${html}`);
  });
  site.listen(0, "127.0.0.1");
  await once(site, "listening");
});

after(async () => {
  site.close();
  await browser.close();
});

/** Calls `steps` with a page of the other site that has the README's three lines, and the server. */
async function withElement(name, options, steps, attributes = "") {
  const allowed = `http://localhost:${site.address().port}`;
  const server = await ServerProcess.start(kSource, 0, ["--allow-origin", allowed, ...options]);
  try {
    const lines = /```html\n(.*?)```/s.exec(kReadme)[1];
    assert.equal(lines.trim().split("\n").length, 3);
    html = lines
      .replaceAll("http://127.0.0.1:8080/", server.url)
      .replace("<fanlight-view", `<fanlight-view ${attributes}`);
    policy = policyFor(server.url.replace(/\/$/, ""));
    const page = await browser.newPage();
    const problems = [];
    page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
    page.on("pageerror", (error) => problems.push(String(error)));
    await page.addInitScript(() => {
      window.pictures = [];
      addEventListener("DOMContentLoaded", () => {
        const view = document.querySelector("fanlight-view");
        view.addEventListener("fanlight-picture", ({ detail }) => window.pictures.push(detail));
      });
    });
    await page.goto(allowed);
    await steps(page, server, problems);
    if (process.env.FANLIGHT_ARTIFACTS) {
      await page.screenshot({ path: join(process.env.FANLIGHT_ARTIFACTS, `${name}.png`) });
    }
    await page.close();
  } finally {
    await server.end();
  }
}

const stateOf = (page) => page.locator("fanlight-view").getAttribute("data-state");
const stateIs = (page, state) =>
  until(
    `state ${state}`,
    () => stateOf(page),
    (now) => now === state,
  );
/** The text of a part in the shadow tree; empty where it is hidden. */
const textOf = (page, selector) =>
  page.evaluate((name) => {
    const part = document.querySelector("fanlight-view").shadowRoot.querySelector(name);
    return part.hidden ? "" : part.textContent;
  }, selector);
const picturesOf = (page) => page.evaluate(() => window.pictures.length);
const lastOf = (page) => page.evaluate(() => ({ ...window.pictures.at(-1) }));
const someMore = async (page) => {
  const before = await picturesOf(page);
  await until(
    "more pictures",
    () => picturesOf(page),
    (now) => now > before + 2,
  );
};
/** Grey levels of the middle of the canvas. */
const pixelsOf = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector("fanlight-view").shadowRoot.querySelector("canvas");
    const { width, height } = canvas;
    const pixels = canvas.getContext("2d").getImageData(width / 4, height / 4, width / 2, height / 2).data;
    return [...pixels].filter((_, index) => index % 4 === 0);
  });
/** Mean difference in grey levels; more than any for pictures of another size. */
const difference = (a, b) =>
  a.length === b.length ? a.reduce((sum, value, index) => sum + Math.abs(value - b[index]), 0) / a.length : 256;

test("three lines of HTML show the stream, and say what it is", async () => {
  await withElement("element", [], async (page, server, problems) => {
    await stateIs(page, "live");
    await someMore(page);
    await until(
      "the origin",
      () => textOf(page, ".word"),
      (word) => word === "Simulated",
    );
    assert.match(await textOf(page, ".age"), /^\d.*s$/);
    assert.match(await textOf(page, ".source"), /phantom|relief|simulated/i);
    const grey = await pixelsOf(page);
    assert.ok(Math.max(...grey) - Math.min(...grey) > 60, "a surface is seen");
    const { width, height } = await lastOf(page);
    const box = await page.locator("fanlight-view").boundingBox();
    assert.equal(Math.round(box.width), 640);
    assert.ok(width <= 640 && height <= 640, `pictures of ${width} x ${height}`);
    assert.deepEqual(problems, [], "a strict content policy is kept");

    // The pictures follow the size of the element.
    await page.evaluate(() => document.querySelector("fanlight-view").setAttribute("style", "width: 200px"));
    await until(
      "smaller pictures",
      () => lastOf(page),
      (last) => last.width <= 200,
    );
    // Taken out of the page, it ends its session.
    const sessions = async () =>
      /fanlight_sessions (\d+)/.exec(await (await fetch(`${server.url}metrics`)).text())?.[1];
    assert.equal(await sessions(), "1");
    await page.evaluate(() => {
      window.view = document.querySelector("fanlight-view");
      window.view.remove();
    });
    await until("no session", sessions, (count) => count === "0");
    await page.evaluate(() => document.body.append(window.view));
    await stateIs(page, "live");
    await someMore(page);
  });
});

test("a server that ends is seen, and one that returns", async () => {
  await withElement("element_lost", [], async (page, server) => {
    await stateIs(page, "live");
    await someMore(page);
    await server.end();
    await stateIs(page, "lost");
    assert.match(await textOf(page, ".notice"), /Connection lost.*not live/);
    assert.match(await textOf(page, ".mark"), /Lost/);
    if (process.env.FANLIGHT_ARTIFACTS)
      await page.screenshot({ path: join(process.env.FANLIGHT_ARTIFACTS, "element_ended.png") });
  });
});

test("a drag turns this element alone, and a button brings the main view back", async () => {
  await withElement(
    "element_turned",
    [],
    async (page, server) => {
      await stateIs(page, "live");
      await someMore(page);
      const freeze = { method: "POST", headers: { "Content-Type": "application/json" }, body: '{"wish": "freeze"}' };
      assert.equal((await fetch(`${server.url}api/cine`, freeze)).status, 202);
      await stateIs(page, "frozen");
      await page.waitForTimeout(1000); // the pictures of the frozen volume become finer
      const before = await pixelsOf(page);
      const sceneOf = async () => (await (await fetch(`${server.url}api/scene`)).json()).scene.camera;
      const camera = await sceneOf();
      const box = await page.locator("fanlight-view").boundingBox();
      await page.mouse.move(box.x + 300, box.y + 300);
      await page.mouse.down();
      await page.mouse.move(box.x + 420, box.y + 330, { steps: 8 });
      await page.mouse.up();
      const button = page.getByRole("button", { name: "back to the main view" });
      await button.waitFor();
      const apart = async () => difference(await pixelsOf(page), before);
      await until("a turned picture", apart, (levels) => levels > 3);
      assert.deepEqual(await sceneOf(), camera, "the others keep their view");
      const turned = await pixelsOf(page);
      await page.keyboard.press("ArrowLeft");
      await until(
        "the keys turn it",
        async () => difference(await pixelsOf(page), turned),
        (levels) => levels > 1,
      );
      if (process.env.FANLIGHT_ARTIFACTS)
        await page.screenshot({ path: join(process.env.FANLIGHT_ARTIFACTS, "element_own_view.png") });
      await button.click();
      await button.waitFor({ state: "hidden" });
      await until("the main view", apart, (levels) => levels < 1);
    },
    "turnable",
  );
});

test("a token is needed, refused, taken", async () => {
  const folder = mkdtempSync(join(tmpdir(), "fanlight-element-"));
  const tokens = join(folder, "tokens");
  const words = ["token", "add", "--tokens", tokens, "--name", "ward", "--role", "viewer"];
  const printed = execFileSync(process.env.FANLIGHT_BIN, words, { encoding: "utf8" });
  const token = printed.trim().split(/\s+/).at(-1);
  await withElement("element_refused", ["--tokens", tokens], async (page) => {
    await stateIs(page, "refused");
    assert.match(await textOf(page, ".notice"), /asks for a token/);
    const set = (value) => page.evaluate((text) => void (document.querySelector("fanlight-view").token = text), value);
    await set("wrong");
    await until(
      "the refusal",
      () => textOf(page, ".notice"),
      (text) => /token/.test(text) && !/asks for/.test(text),
    );
    let attempts = 0;
    page.on("websocket", () => ++attempts);
    await page.waitForTimeout(3000);
    assert.equal(attempts, 0, "a refused token is not tried again");
    await set(token);
    await stateIs(page, "live");
    await someMore(page);
    assert.ok(!(await page.content()).includes(token), "the token is not in the document");
  });
});

test("a wrong attribute is said", async () => {
  await withElement("element_wrong", [], async (page, server) => {
    await stateIs(page, "live");
    const set = (name, value) =>
      page.evaluate((pair) => document.querySelector("fanlight-view").setAttribute(...pair), [name, value]);
    await set("rate", "many");
    await stateIs(page, "refused");
    assert.match(await textOf(page, ".notice"), /rate is "many", expected pictures a second/);
    await set("rate", "5");
    await stateIs(page, "live");
    await set("src", "ftp://127.0.0.1/");
    await stateIs(page, "refused");
    assert.match(await textOf(page, ".notice"), /expected http/);
    await set("src", server.url);
    await stateIs(page, "live");
  });
});

test("the npm package is complete", () => {
  const listed = execFileSync("npm", ["pack", "--dry-run", "--json", "--offline"], {
    cwd: process.env.FANLIGHT_ELEMENT,
    encoding: "utf8",
  });
  const [{ name, version, files }] = JSON.parse(listed);
  assert.equal(name, "fanlight-view");
  assert.match(version, /^\d+\.\d+\.\d+/);
  const names = files.map(({ path }) => path).sort();
  assert.deepEqual(names, ["LICENSE", "README.md", "fanlight-view.d.ts", "fanlight-view.js", "package.json"]);
});
