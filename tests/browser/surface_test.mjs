// SPDX-License-Identifier: Apache-2.0
// Surfaces that the page lights itself, by WebGL in Chromium on the processor (SwiftShader), against the pictures of
// the server.
import assert from "node:assert/strict";
import { copyFileSync, mkdtempSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { after, before, test } from "node:test";
import { ServerProcess } from "./server_process.mjs";
import { differences, thumbnail } from "./surface_pictures.mjs";
import { difference, launchChromium, placeOf, until, ViewerPage } from "./viewer_page.mjs";

// Of 255. What remains is the step of the depths, and rounding.
const kMostMean = 0.5;
// A few pixels: the certainty of 2 x 2 pixels is that of one of them, and colour maps are steep.
const kMostAnywhere = 110;
const kWhole = { left: 0, top: 0 }; // picture

let browser;
before(async () => {
  browser = await launchChromium({ webGl: true });
});
after(() => browser?.close());

async function change(server, scene) {
  const response = await fetch(`${server.url}api/scene`, {
    method: "PATCH",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(scene),
  });
  assert.equal(response.status, 200, await response.text());
}

/** Waits until the page shows the scene in force, at rest. */
async function settled(viewer) {
  await viewer.page.waitForTimeout(300); // for the change to arrive
  await viewer.settled();
  await viewer.page.waitForTimeout(400); // for the light to rest
}

/** Waits until the page lights what it shows, and that has faded in: to begin with it has pictures of the server. */
async function litHere(viewer) {
  await until(
    "a surface that the page lights",
    () => viewer.stat("stream"),
    (text) => text.startsWith("surface, lit here"),
  );
  let before = [];
  await until(
    "a picture at rest",
    async () => {
      await viewer.page.waitForTimeout(500);
      const last = before;
      before = await viewer.greyLevels();
      return difference(last, before);
    },
    (by) => by === 0,
  );
}

/**
 * Waits until the page's picture is the server's within the limits. Both may still be on their way under load: the page
 * is at rest only after its cast has faded in, and /api/picture.png may have the scene before.
 */
function alike(viewer, name, part, isAlike) {
  return until(
    `${name}: the picture of the server`,
    () => viewer.page.evaluate(differences, part),
    (found) => found.light > 20 && isAlike(found),
  );
}

const isExact = ({ mean, most }) => mean < kMostMean && most <= kMostAnywhere;

test("the page lights surfaces as the server does", async () => {
  const server = await ServerProcess.start("phantom:probe=r1,volumes=1", 0, [
    "--size",
    "320x256",
    "--size-max",
    "320x256",
  ]);
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    const codec = () => viewer.page.locator("#codec").inputValue();
    await until("a surface, for which it tries again where it was too slow", codec, (now) => now === "3");
    await settled(viewer);
    const plain = {
      light: { fade_mm: 0, occlusion: 0 },
      material: { scatter_mm: 0 },
    };
    const scenes = {
      "as it is": {},
      "the light elsewhere": { light: { right_mm: 60, up_mm: -20 } },
      "a directional light": { light: { kind: "directional" } },
      "hard shadows": { shadow: { softness_mm: 0, coefficient: 0.1 } },
      perspective: { camera: { projection: "perspective", yaw_deg: 20 } },
      "gold, diffused": { finish: { colours: "gold", smoothing: "diffusion" } },
      heat: { finish: { colours: "heat", smoothing: "none" } },
      ice: { finish: { colours: "ice" } },
      sepia: { finish: { colours: "sepia" } },
      grey: { finish: { colours: "grey" } },
      "neither soft nor coloured": { ...plain, finish: { colours: "none", smoothing: "mean", tone: "film" } },
      "three neighbours": { light: { normals: "three-neighbours", specular: 0.5, shininess: 40 } },
      "no shadow": { shadow: { coefficient: 1 }, light: { normals: "central" } },
      "a glow": { material: { scatter_mm: 4, glow: 0.8 }, light: { depth_mm: 60 } },
      "three coloured lights": {
        fill_light: { on: 1, right_mm: 60, up_mm: -40, red: 0.2, strength: 0.6 },
        back_light: { on: 1, up_mm: 70, depth_mm: 90, blue: 0.3, strength: 1.5 },
      },
      "the fill light alone": { light: { on: 0 }, back_light: { on: 0 } },
      "no light on": { fill_light: { on: 0 } },
      "a depth map": { mode: "depth" },
    };
    for (const [name, scene] of Object.entries(scenes)) {
      await change(server, scene);
      await settled(viewer);
      await alike(viewer, name, kWhole, isExact);
    }
    // Planes beside the surface come as a picture; the surface is lit here.
    await change(server, { mode: "slices" });
    await settled(viewer);
    await alike(viewer, "beside planes", { left: 0.5, top: 0.5 }, ({ mean, most }) => mean < kMostMean && most <= 30);
    await change(server, { mode: "volume" });
    await settled(viewer);
    await alike(viewer, "the volume, as JPEG", kWhole, ({ mean }) => mean < 4);
    assert.deepEqual(viewer.consoleProblems, []);
    await viewer.screenshot("surface");
    await viewer.page.close();
  } finally {
    await server.end();
  }
});

test("a moved light is seen before the server has drawn it", async () => {
  const server = await ServerProcess.start("phantom:probe=r1,volumes=1", 0, [
    "--size",
    "256x256",
    "--size-max",
    "256x256",
  ]);
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    await settled(viewer);
    await litHere(viewer);
    await server.send("SIGSTOP");
    const before = await viewer.greyLevels();
    await viewer.page.locator("#picture").press("ArrowRight");
    await viewer.changedFrom(before, 0.2, "a light that the server has not seen");
    await until(
      "a mark that the server has not drawn it",
      () => viewer.page.locator("#picture").getAttribute("aria-busy"),
      (busy) => busy === "true",
    );
    await server.send("SIGCONT");
    await viewer.settled();
    await viewer.page.close();
  } finally {
    await server.send("SIGCONT");
    await server.end();
  }
});

test("an own light costs the server nothing and disturbs nobody", async () => {
  const server = await ServerProcess.start("phantom:probe=r1,volumes=1", 0, [
    "--size",
    "256x256",
    "--size-max",
    "256x256",
  ]);
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    const other = await ViewerPage.open(browser, server.url);
    for (const each of [viewer, other]) {
      await settled(each);
      await litHere(each);
    }
    const [before, atOther] = [await viewer.greyLevels(), await other.greyLevels()];
    await viewer.page.locator("#own-view input").check();
    for (let press = 0; press < 5; ++press) await viewer.page.locator("#picture").press("ArrowRight");
    await viewer.changedFrom(before, 0.5, "an own light");
    await settled(viewer);
    const metrics = await (await fetch(`${server.url}metrics`)).text();
    assert.match(metrics, /^fanlight_private_views 0$/m);
    assert.match(metrics, /^fanlight_pass2_runs_total 1$/m);
    assert.deepEqual(await other.greyLevels(), atOther);
    // Pictures of the server instead: it has to know the light then, and draws the same.
    const lit = await viewer.greyLevels();
    await viewer.page.locator("#codec").evaluate((select) => {
      select.value = "1";
      select.dispatchEvent(new Event("change"));
    });
    await until(
      "a private view",
      async () => (await (await fetch(`${server.url}metrics`)).text()).includes("fanlight_private_views 1"),
      (opened) => opened,
    );
    await viewer.becomes(lit, 0.5, "the server's picture by the own light");
    await viewer.page.locator("#own-view input").uncheck();
    await viewer.settled();
    await viewer.becomes(before, 0.5, "the main light again");
    for (const each of [viewer, other]) await each.page.close();
  } finally {
    await server.end();
  }
});

test("a turned picture is a preview until the server has cast it", async () => {
  const server = await ServerProcess.start("phantom:probe=r1,volumes=1", 0, [
    "--size",
    "256x256",
    "--size-max",
    "256x256",
  ]);
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    await settled(viewer);
    await litHere(viewer);
    // A note on the surface turns with it.
    const noteX = async () => (await placeOf(viewer.page.locator("#picture-notes .on-surface"))).x;
    await viewer.page.locator("body").press("n");
    const { width, height } = await viewer.page.locator("#picture").boundingBox();
    await viewer.page.locator("#picture").click({ position: { x: 0.45 * width, y: 0.45 * height } });
    await viewer.page.locator("#picture-notes input").fill("nose");
    await viewer.page.locator("#picture-notes input").press("Enter");
    const noteBefore = await noteX();
    await viewer.page.locator("body").press("t");
    const before = await viewer.greyLevels();
    server.send("SIGSTOP");
    for (let press = 0; press < 3; ++press) await viewer.page.locator("#picture").press("ArrowRight");
    await viewer.changedFrom(before, 2, "a turn that the server has not seen");
    assert.equal(await viewer.page.locator("#rendering").innerText(), "Preview …");
    const noteMoved = (await noteX()) - noteBefore;
    assert.ok(Math.abs(noteMoved) > 5, `the note moved by ${noteMoved} pixels of the page`);
    const turned = await viewer.greyLevels();
    // Nothing to save or to measure.
    await viewer.page.locator("#still").click();
    await until(
      "a refusal",
      () => viewer.page.locator("#refusal").innerText(),
      (text) => text.includes("preview"),
    );
    server.send("SIGCONT");
    await viewer.settled();
    await settled(viewer);
    await viewer.page.locator("#rendering").waitFor({ state: "hidden" });
    await alike(viewer, "the cast", kWhole, ({ mean }) => mean < kMostMean);
    const cast = await viewer.greyLevels();
    const [jump, way] = [difference(turned, cast), difference(before, cast)];
    assert.ok(jump < way / 2, `the preview is ${jump} off, and the picture from before the turn ${way}`);
    await viewer.page.close();
  } finally {
    server.send("SIGCONT");
    await server.end();
  }
});

test("a frozen volume that was seen before is shown at once", async () => {
  const server = await ServerProcess.start("phantom:probe=r1,rate=20", 0, [
    "--size",
    "192x192",
    "--size-max",
    "192x192",
  ]);
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    await until(
      "a few volumes",
      () => viewer.number("volume-id"),
      (id) => id >= 4,
    );
    const press = (key) => viewer.page.locator("body").press(key);
    // Key and number in one turn of the page: no picture comes between.
    const frozenAt = await viewer.page.evaluate(() => {
      document.body.dispatchEvent(new KeyboardEvent("keydown", { key: " ", bubbles: true }));
      return Number(document.querySelector('[data-stat="volume-id"]').textContent);
    });
    const shows = (id) =>
      until(
        `volume ${id}`,
        () => viewer.number("volume-id"),
        (now) => now === id,
      );
    await until(
      "a frozen picture",
      () => viewer.page.locator("#connection [role=status]").textContent(),
      (word) => word === "Frozen",
    );
    await viewer.settled();
    await viewer.page.waitForTimeout(500);
    const newest = await viewer.number("volume-id");
    assert.equal(newest, frozenAt, "what the user saw is frozen, though the server has newer volumes");
    await press(",");
    const before = await until(
      "the volume before",
      () => viewer.number("volume-id"),
      (id) => id < newest,
    );
    await viewer.page.waitForTimeout(500); // for the state of the cine
    await press(".");
    await shows(newest);
    await viewer.page.waitForTimeout(500);
    server.send("SIGSTOP");
    const seen = await viewer.greyLevels();
    await press(",");
    await shows(before);
    assert.notDeepEqual(await viewer.greyLevels(), seen);
    await press(".");
    await shows(newest);
    await viewer.becomes(seen, 0.5, "the picture that was seen, drawn finely");
    server.send("SIGCONT");
    await viewer.page.waitForTimeout(1000);
    await shows(newest);
    await viewer.page.close();
  } finally {
    server.send("SIGCONT");
    await server.end();
  }
});

test("a picture at rest gets as sharp as the page, and is quick while it moves", async () => {
  const kUsual = 128; // small: the size that a page asks for depends on how quickly it lights
  const server = await ServerProcess.start("phantom:probe=r1,volumes=1", 0, ["--size", `${kUsual}x${kUsual}`]);
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    const widthOf = () => viewer.page.locator("#picture").evaluate((canvas) => canvas.width);
    const sharp = () => until("a finer picture", widthOf, (width) => width > kUsual);
    await settled(viewer);
    const shown = await viewer.page.locator("#frame").boundingBox();
    const usual = await viewer.page.evaluate(thumbnail);
    const width = await sharp();
    assert.ok(width <= Math.ceil(shown.width), `${width} pixels on ${shown.width}`);
    await until(
      "a finer picture of the same surface",
      async () => difference(usual, await viewer.page.evaluate(thumbnail)),
      (apart) => apart < 4,
    );
    assert.match(await viewer.page.locator('[data-stat="stream"]').textContent(), /^surface, lit here, \d+ × \d+$/);
    // A moved view is usual and coarse at first; its fine picture comes when it rests.
    const casts = await viewer.number("pass1-runs");
    await viewer.page.locator('#tools input[value="orbit"]').evaluate((radio) => radio.click());
    await viewer.page.locator("#picture").press("ArrowRight");
    await until("the usual size", widthOf, (now) => now === kUsual);
    await sharp();
    assert.ok((await viewer.number("pass1-runs")) > casts + 1);
    // A distance has its length in any size.
    await viewer.page.locator('#tools input[value="measure"]').evaluate((radio) => radio.click());
    const measured = (said) =>
      until(
        said,
        () => viewer.page.locator("#measured").innerText(),
        (text) => text.includes(said),
      );
    await measured("Click the first of two points");
    await sharp();
    const [from, to] = [0.45, 0.55].map((share) => shown.x + share * shown.width);
    const y = shown.y + 0.4 * shown.height;
    await viewer.page.mouse.click(from, y);
    await viewer.page.mouse.click(to, y);
    const mm = Number(/([\d.]+) ± [\d.]+ mm straight/.exec(await measured("mm straight"))[1]);
    const { camera } = (await (await fetch(`${server.url}api/scene`)).json()).scene;
    const across = 0.1 * camera.field_mm;
    assert.ok(mm > 0.9 * across && mm < 3 * across, `${mm} mm, ${across} mm across`);
    // From behind it is faint.
    const faint = viewer.page.locator("#measurement text.behind");
    await viewer.page.locator("#views").getByRole("button", { name: "Back" }).click();
    await until(
      "a faint distance",
      () => faint.count(),
      (count) => count === 1,
    );
    await viewer.screenshot("measured-from-behind");
    await viewer.page.locator("#views").getByRole("button", { name: "Front" }).click();
    await until(
      "the distance on the near side",
      () => faint.count(),
      (count) => count === 0,
    );
    assert.deepEqual(viewer.consoleProblems, []);
    await viewer.screenshot("sharp");
    await viewer.page.close();
  } finally {
    await server.end();
  }
});

test("volumes that were seen are played without the server", async () => {
  const options = ["--size", "192x192", "--size-max", "192x192", "--cine-volumes", "3"];
  const server = await ServerProcess.start("phantom:probe=r1,rate=20", 0, options);
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    await until(
      "a few volumes",
      () => viewer.number("volume-id"),
      (id) => id >= 5,
    );
    await viewer.page.locator("body").press(" ");
    await until(
      "a frozen picture",
      () => viewer.page.locator("#connection [role=status]").textContent(),
      (word) => word === "Frozen",
    );
    const text = () => viewer.page.locator('[data-cine="text"]').textContent();
    const volumes = Number(/ of (\d+)/.exec(await text())[1]);
    assert.ok(volumes > 1, await text());
    await viewer.page.locator('[data-cine="main"]').click();
    const seen = new Set();
    const all = () =>
      until(
        "all volumes",
        async () => seen.add(await viewer.number("volume-id")).size,
        (size) => size >= volumes,
      );
    await all();
    await all();
    await viewer.page.waitForTimeout(3000); // the page knows them all now
    server.send("SIGSTOP");
    seen.clear();
    await viewer.page.waitForTimeout(200); // what was on its way
    await all();
    server.send("SIGCONT");
    // It stops at what is seen here, wherever the server is.
    await viewer.page.locator('[data-cine="main"]').click();
    const isStill = async () => {
      const before = await viewer.number("volume-id");
      await viewer.page.waitForTimeout(1500);
      return (await viewer.number("volume-id")) === before;
    };
    await until("one volume for a second and a half", isStill, Boolean); // a busy machine is late
    await viewer.page.close();
  } finally {
    server.send("SIGCONT");
    await server.end();
  }
});

test("the shared file shows the surface, turns and measures without a server", async () => {
  const server = await ServerProcess.start("phantom:probe=r1,volumes=1", 0, [
    "--size",
    "256x256",
    "--size-max",
    "256x256",
  ]);
  const folder = mkdtempSync(join(tmpdir(), "fanlight-shared-"));
  const file = join(folder, "surface.html");
  let ofServer;
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    await settled(viewer);
    const download = viewer.page.waitForEvent("download");
    await viewer.page.locator("#share").click();
    const saved = await download;
    assert.match(saved.suggestedFilename(), /^fanlight-.*\.html$/);
    copyFileSync(await saved.path(), file); // a browser takes the type of a file from its name
    ofServer = await viewer.greyLevels();
    await viewer.page.close();
  } finally {
    await server.end();
  }
  assert.ok(statSync(file).size < 1_000_000);
  const shared = new ViewerPage();
  shared.page = await browser.newPage({ viewport: { width: 900, height: 700 } });
  const requests = [];
  const problems = [];
  shared.page.on("request", (request) => requests.push(request.url()));
  shared.page.on("pageerror", (error) => problems.push(String(error)));
  await shared.page.goto(pathToFileURL(file).href);
  await shared.becomes(ofServer, 1, "the surface of the server's picture");
  await shared.page.waitForTimeout(500);
  const before = await shared.greyLevels();
  await shared.drag([0.5, 0.5], [0.6, 0.5]);
  await shared.changedFrom(before, 2, "a turn");
  await shared.page.locator("#reset").click();
  await shared.becomes(before, 0.5, "the first view");
  await shared.page.locator("#tools").getByText("Measure").click();
  const box = await shared.page.locator("#picture").boundingBox();
  await shared.page.mouse.click(box.x + 0.45 * box.width, box.y + 0.5 * box.height);
  await shared.page.mouse.click(box.x + 0.6 * box.width, box.y + 0.5 * box.height);
  assert.match(await shared.page.locator("#said").textContent(), /^\d+\.\d mm straight\. Not for diagnosis\.$/);
  assert.deepEqual(requests, [pathToFileURL(file).href]);
  assert.deepEqual(problems, []);
  await shared.page.close();
  rmSync(folder, { recursive: true });
});
