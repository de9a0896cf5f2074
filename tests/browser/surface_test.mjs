// SPDX-License-Identifier: Apache-2.0
// Surfaces that the page lights itself, by WebGL in Chromium on the processor (SwiftShader), against the pictures of
// the server.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { ServerProcess } from "./server_process.mjs";
import { launchChromium, ViewerPage } from "./viewer_page.mjs";

// Of 255. What remains is the step of the depths, and rounding.
const kMostMean = 0.5;
const kMostAnywhere = 16;

let browser;
before(async () => {
  browser = await launchChromium({ webGl: true });
});
after(() => browser?.close());

/** Runs in the page: how its picture differs from the server's picture of the same scene, in the part given. */
async function differences(part) {
  const pixelsOf = (image, width, height) => {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { width, height });
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    return context.getImageData(part.left * width, part.top * height, width, height).data;
  };
  const shown = document.querySelector("#picture");
  const bitmap = await createImageBitmap(await (await fetch("/api/picture.png")).blob());
  const [a, b] = [shown, bitmap].map((image) => pixelsOf(image, bitmap.width, bitmap.height));
  let [sum, most, count, light] = [0, 0, 0, 0];
  for (let at = 0; at < a.length; ++at) {
    if (at % 4 === 3 || a[4 * (at >> 2) + 3] === 0) continue; // beyond the canvas
    const apart = Math.abs(a[at] - b[at]);
    sum += apart;
    light += b[at];
    most = Math.max(most, apart);
    ++count;
  }
  return { mean: sum / count, most, light: light / count, width: shown.width };
}

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

test("the page lights surfaces as the server does", async () => {
  const server = await ServerProcess.start("phantom:probe=r1,volumes=1", 0, ["--size", "320x256"]);
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    await settled(viewer);
    assert.equal(await viewer.page.locator("#codec").inputValue(), "3");
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
      "a depth map": { mode: "depth" },
    };
    for (const [name, scene] of Object.entries(scenes)) {
      await change(server, scene);
      await settled(viewer);
      const found = await viewer.page.evaluate(differences, { left: 0, top: 0 });
      assert.ok(found.light > 5, `${name}: the picture is dark`);
      assert.ok(found.mean < kMostMean && found.most <= kMostAnywhere, `${name}: ${JSON.stringify(found)}`);
    }
    // Planes beside the surface come as a picture; the surface is lit here.
    await change(server, { mode: "slices" });
    await settled(viewer);
    const beside = await viewer.page.evaluate(differences, { left: 0.5, top: 0.5 });
    assert.ok(beside.mean < kMostMean && beside.most <= 30, JSON.stringify(beside));
    await change(server, { mode: "volume" });
    await settled(viewer);
    const volume = await viewer.page.evaluate(differences, { left: 0, top: 0 });
    assert.ok(volume.mean < 4, `the volume, as JPEG: ${JSON.stringify(volume)}`);
    assert.deepEqual(viewer.consoleProblems, []);
    await viewer.screenshot("surface");
    await viewer.page.close();
  } finally {
    await server.end();
  }
});

test("a moved light is seen before the server has drawn it", async () => {
  const server = await ServerProcess.start("phantom:probe=r1,volumes=1", 0, ["--size", "256x256"]);
  try {
    const viewer = await ViewerPage.open(browser, server.url);
    await settled(viewer);
    await server.send("SIGSTOP");
    const before = await viewer.greyLevels();
    await viewer.page.locator("#picture").press("ArrowRight");
    await viewer.changedFrom(before, 0.2, "a light that the server has not seen");
    assert.equal(await viewer.page.locator("#picture").getAttribute("aria-busy"), "true");
    await server.send("SIGCONT");
    await viewer.settled();
    await viewer.page.close();
  } finally {
    await server.send("SIGCONT");
    await server.end();
  }
});
