// SPDX-License-Identifier: Apache-2.0
// Tests the tools of the page in Chromium against the real server: notes, near tissue, saved presets, clips, and what a
// display may do that is not in control. Variables: see viewer_test.mjs.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { setTimeout as pause } from "node:timers/promises";
import { difference, placeOf, until } from "./viewer_page.mjs";
import { kStillSource, withPage, withStillPage } from "./with_page.mjs";

const kMovingSource = "phantom:scene=relief,probe=r1,frames=18,rate=20,speckle=off";

const press = (viewer, key) => viewer.page.keyboard.press(key);
const click = (viewer, selector) => viewer.page.locator(selector).click();

test("a button removes near tissue from the volume on show, or says that it found none", async () => {
  const mark = (viewer) => viewer.page.locator("#near-tissue-mark");
  const pressed = (viewer) => viewer.page.locator("#near-tissue").getAttribute("aria-pressed");
  await withPage("womb", "phantom:scene=womb,seed=13,volumes=1", async (viewer) => {
    await viewer.firstPicture();
    assert.equal(await mark(viewer).isVisible(), false);
    await click(viewer, "#near-tissue");
    await mark(viewer).waitFor({ state: "visible" });
    assert.equal(await mark(viewer).textContent(), "Near tissue removed");
    assert.equal(await pressed(viewer), "true");
    await click(viewer, "#near-tissue");
    await mark(viewer).waitFor({ state: "hidden" });
    assert.equal(await pressed(viewer), "false");
    await press(viewer, "4");
    await viewer.settled();
    const handle = viewer.page.locator('#planes .grip[data-line="near-end"]');
    assert.equal(await handle.count(), 0);
    await click(viewer, "#near-tissue");
    await mark(viewer).waitFor({ state: "visible" });
    await viewer.settled();
    assert.equal(await handle.count(), 2, "in the two panes that show the depth");
    const boxOf = () => placeOf(handle.first());
    // Beside the line of the other plane, which crosses the handle in its middle.
    const grabPoint = ({ x, y, width, height }) => ({ x: x + width / 4, y: y + height / 2 });
    const before = grabPoint(await boxOf());
    await viewer.page.mouse.move(before.x, before.y);
    await viewer.page.mouse.down();
    for (const down of [5, 10, 20]) await viewer.page.mouse.move(before.x, before.y + down);
    await viewer.page.mouse.up();
    await viewer.page.waitForFunction((y) => {
      const grip = document.querySelector('#planes .grip[data-line="near-end"]');
      return grip && Math.abs(grip.getBoundingClientRect().y + grip.getBoundingClientRect().height / 2 - y) < 4;
    }, before.y + 20);
    await viewer.settled();
    const after = grabPoint(await boxOf());
    assert.ok(Math.abs(after.y - before.y - 20) < 4, `the line moved by ${after.y - before.y} of 20 pixels`);
    assert.deepEqual(viewer.consoleProblems, []);
  });
  await withPage("no-womb", `${kStillSource},clutter=off`, async (viewer) => {
    await viewer.firstPicture();
    await click(viewer, "#near-tissue");
    await mark(viewer).waitFor({ state: "visible" });
    assert.match(await mark(viewer).textContent(), /nothing removed/);
  });
});

test("a mark says how much of the surface is uncertain", async () => {
  await withStillPage("uncertain", async (viewer) => {
    await viewer.firstPicture();
    const mark = viewer.page.locator("#uncertain-mark");
    assert.equal(await mark.isVisible(), false);
    const setLeastContrast = async (greyLevels) => {
      const box = viewer.page.locator('[data-number="detector.least_contrast"]');
      await viewer.unfold("detector");
      await box.fill(String(greyLevels));
      await box.press("Enter");
    };
    await setLeastContrast(60);
    await mark.waitFor({ state: "visible" });
    assert.match(await mark.textContent(), /^\d\d+ % of the surface is uncertain \(dimmed\)$/);
    await setLeastContrast(0);
    await mark.waitFor({ state: "hidden" });
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("keys set points and notes, and move planes and the sides of the crop box", async () => {
  await withStillPage("keys", async (viewer) => {
    await viewer.firstPicture();
    const picture = viewer.page.locator("#picture");
    const onPicture = async (...keys) => {
      await picture.focus();
      for (const key of keys) await picture.press(key);
    };
    await press(viewer, "n");
    await onPicture("ArrowRight", "Shift+ArrowUp", "Enter");
    const input = viewer.page.locator("#picture-notes input");
    await input.fill("by keys");
    await input.press("Enter");
    const note = await placeOf(viewer.page.locator("#picture-notes button"));
    const { y, height } = await picture.boundingBox();
    assert.ok(note.y < y + 0.48 * height, "it stands above the middle, where the cross was moved to");
    await press(viewer, "m");
    await until(
      "a frozen picture",
      () => viewer.page.locator("#measured").textContent(),
      (text) => text.startsWith("Click the first of two points"),
    );
    await onPicture("ArrowLeft", "Enter", "Shift+ArrowRight", "Enter");
    await until(
      "a distance",
      () => viewer.page.locator("#measured").textContent(),
      (text) => / mm straight/.test(text),
    );
    await press(viewer, "4");
    await viewer.settled();
    const plane = await viewer.field("camera.target_x_mm");
    await viewer.page.locator('#planes [aria-label^="Plane B"]').first().focus();
    await press(viewer, "Shift+ArrowRight");
    await until(
      "a moved plane",
      () => viewer.field("camera.target_x_mm"),
      (now) => now > plane,
    );
    await press(viewer, "c");
    await viewer.page.locator('#planes [aria-label^="Left side"]').first().focus();
    await press(viewer, "ArrowRight");
    await viewer.settled();
    const left = await viewer.field("crop.left_mm");
    assert.ok(left > -1000);
    await press(viewer, "ArrowRight"); // the focus is still there
    await until(
      "the left side",
      () => viewer.field("crop.left_mm"),
      (now) => now > left,
    );
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("notes stand on the picture and its still, which needs no scale", async () => {
  await withStillPage("notes", async (viewer) => {
    await viewer.firstPicture();
    const note = async (text) => {
      const input = viewer.page.locator("#picture-notes input");
      await input.waitFor();
      await input.fill(text);
      await input.press("Enter");
    };
    await press(viewer, "n");
    const { x, y, width, height } = await viewer.page.locator("#picture").boundingBox();
    await viewer.page.mouse.click(x + 0.3 * width, y + 0.2 * height);
    await note("left hand"); // its letters are no keys of the page
    assert.equal(await viewer.page.locator("#picture-notes button").textContent(), "left hand");
    assert.equal(await viewer.page.locator('#tools input[value="note"]').isChecked(), true);
    const stillHeight = async () => {
      const saved = viewer.page.waitForEvent("download");
      await click(viewer, "#still");
      return readFileSync(await (await saved).path()).readUInt32BE(20);
    };
    const withScale = await stillHeight();
    await click(viewer, "#still-facts");
    const without = await stillHeight();
    assert.equal(without, await viewer.page.locator("#picture").evaluate((canvas) => canvas.height));
    assert.ok(withScale > without);
    await click(viewer, "#picture-notes button");
    await note("");
    assert.equal(await viewer.page.locator("#picture-notes > *").count(), 0, "an empty text removes the note");
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a preset is saved for all displays, survives the server, and goes to a file and back", async () => {
  const folder = mkdtempSync(join(tmpdir(), "presets_"));
  const file = join(folder, "saved", "presets.json");
  const steps = async (viewer, server) => {
    const buttons = (of = viewer) => of.page.locator("#presets button").allTextContents();
    const hasButton = (name, of = viewer) =>
      until(
        name,
        () => buttons(of),
        (texts) => texts.includes(name),
      );
    await viewer.firstPicture();
    await viewer.page.locator('[data-quick="detector.threshold"]').fill("33");
    await viewer.settled();
    await click(viewer, "#own-presets summary");
    await viewer.page.locator("#own-presets [type=text]").fill("bright skin");
    await viewer.page.locator("#own-presets [type=text]").press("Enter");
    await hasButton("bright skin");
    const other = await server.openPage();
    await hasButton("bright skin", other);
    await other.page.close();
    await click(viewer, '[data-preset="bone"]');
    await viewer.settled();
    await click(viewer, '#presets button[value="bright skin"]');
    await viewer.settled();
    assert.equal(await viewer.field("detector.threshold"), 33);

    const saved = viewer.page.waitForEvent("download");
    await click(viewer, '[data-preset-wish="export"]');
    const path = await (await saved).path();
    const json = JSON.parse(readFileSync(path, "utf8"));
    assert.equal(json.detector.threshold, 33);
    assert.equal(json.mode, "surface", "a choice by its name");
    assert.equal(json.camera, undefined, "the view is no part of a preset");
    await viewer.page.locator("#own-presets [type=text]").fill("from a file");
    await viewer.page.locator("#own-presets [type=file]").setInputFiles(path);
    await hasButton("from a file");
    await viewer.page
      .locator("#own-presets [type=file]")
      .setInputFiles({ name: "x.json", mimeType: "application/json", buffer: Buffer.from('{"no": 1}') });
    await until(
      "a refusal",
      () => viewer.page.locator("#refusal > span").textContent(),
      (text) => /no field no/.test(text),
    );

    await viewer.page.locator("#own-presets [type=text]").fill("bright skin");
    await click(viewer, '[data-preset-wish="remove"]');
    await until("one preset less", buttons, (texts) => !texts.includes("bright skin"));
    await until(
      "the file",
      () => existsSync(file) && readFileSync(file, "utf8"),
      (text) => text && !text.includes("bright skin"),
    );
    await server.end();
    await server.restart();
    await until(
      "the connection",
      () => viewer.connection(),
      (state) => state === "open",
    );
    await hasButton("from a file");
    await viewer.page.locator("#own-presets [type=text]").fill("bone");
    await viewer.page.locator("#own-presets [type=text]").press("Enter");
    await until(
      "a refusal",
      () => viewer.page.locator("#refusal > span").textContent(),
      (text) => /Bone is a built-in preset/.test(text),
    );
  };
  try {
    await withPage("own-presets", kStillSource, steps, ["--presets", file]);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test("a clip is an MP4 file of the pictures as they came", async () => {
  await withPage("clip", kMovingSource, async (viewer) => {
    await viewer.firstPicture();
    await press(viewer, "v");
    const atStart = await viewer.number("volume-id");
    await until(
      "pictures of further volumes",
      () => viewer.number("volume-id"),
      (id) => id >= atStart + 4,
    );
    await until(
      "some seconds",
      () => viewer.page.locator("#clip").textContent(),
      (text) => Number(/Stop clip (\d+) s/.exec(text)?.[1]) >= 3,
    );
    const saved = viewer.page.waitForEvent("download");
    await click(viewer, "#clip");
    const download = await saved;
    assert.match(download.suggestedFilename(), /^fanlight-.*\.mp4$/);
    const probe = JSON.parse(
      execFileSync("ffprobe", ["-v", "error", "-count_frames", "-show_streams", "-of", "json", await download.path()]),
    ).streams[0];
    assert.equal(probe.codec_name, "h264");
    assert.ok(Number(probe.duration) > 1.5, probe.duration);
    assert.ok(Number(probe.nb_read_frames) >= 3, probe.nb_read_frames);
    assert.equal(probe.width, await viewer.page.locator("#picture").evaluate((canvas) => canvas.width));
    assert.equal(await viewer.page.locator("#codec").inputValue(), "0", "the stream is as it was chosen");
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a display without control freezes its own picture only, and says so", async () => {
  await withPage("own-freeze", kMovingSource, async (viewer, server) => {
    await viewer.firstPicture();
    await viewer.page.locator('[data-quick="finish.exposure"]').fill("60"); // takes control
    await viewer.settled();
    const other = await server.openPage();
    await other.firstPicture();
    const freeze = other.page.locator('[data-cine="freeze"]');
    await until(
      "the other's button",
      () => freeze.textContent(),
      (text) => text.trim() === "Freeze here",
    );
    await other.page.keyboard.press(" ");
    await until(
      "its mark",
      () => other.page.locator("#not-live").textContent(),
      (text) => /^Frozen on this display only/.test(text),
    );
    const kept = await other.number("volume-id");
    const others = await viewer.number("volume-id");
    await until(
      "the first continues",
      () => viewer.number("volume-id"),
      (id) => id > others + 3,
    );
    assert.equal(await other.number("volume-id"), kept);
    await other.screenshot("frozen-here");
    await freeze.click();
    await until(
      "new volumes",
      () => other.number("volume-id"),
      (id) => id > kept + 3,
    );
    assert.deepEqual(other.consoleProblems, []);
    await other.page.close();
  });
});

test("an own light works beside volumes that leave the machine some time", async () => {
  await withPage("own-light", "phantom:scene=relief,probe=r1,frames=12,rate=6", async (viewer) => {
    await viewer.firstPicture();
    // The first pictures pay for the shaders, and the cost of an own light is estimated by the last ones.
    const first = await viewer.number("volume-id");
    await until(
      "steady pictures",
      () => viewer.number("volume-id"),
      (id) => id > first + 3,
    );
    // A machine that has other work refuses the view or ends it, with a sentence: once it works, that is enough.
    const refusal = viewer.page.locator("#refusal");
    let attempts = 0;
    const ownPictures = async () => {
      if (await refusal.isVisible()) await click(viewer, "#refusal button");
      if (!(await viewer.page.isChecked("#own-view input"))) await click(viewer, "#own-view input");
      await viewer.drag([0.2, 0.2], [attempts++ % 2 ? 0.5 : 0.6, 0.3]);
      await viewer.settled();
      const volume = await viewer.number("volume-id");
      const [isRefused] = await until(
        "own pictures of new volumes, or a refusal",
        async () => [await refusal.isVisible(), await viewer.number("volume-id")],
        ([isRefused, id]) => isRefused || id > volume + 2,
      );
      return !isRefused;
    };
    await until("an own light for three volumes", ownPictures, (isOwn) => isOwn);
  });
});

test("with forced colours what is chosen stays visible", async () => {
  await withStillPage("forced-colours", async (viewer) => {
    await viewer.firstPicture();
    await viewer.page.emulateMedia({ forcedColors: "active" });
    await press(viewer, "4");
    await press(viewer, "c");
    await viewer.settled();
    await pause(200);
    const colourOf = (selector) =>
      viewer.page
        .locator(selector)
        .first()
        .evaluate((part) => getComputedStyle(part).backgroundColor);
    const chosen = await colourOf("#tools label:has(input:checked) span");
    const other = await colourOf("#tools label:not(:has(input:checked)) span");
    assert.notEqual(chosen, other, "the chosen tool looks like the others");
    await viewer.screenshot("forced-colours-crop");
    await viewer.page.emulateMedia({ forcedColors: "none" });
  });
});
