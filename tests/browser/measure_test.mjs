// SPDX-License-Identifier: Apache-2.0
// Tests measurements in planes and on the surface in Chromium against the real server, by mouse and keys.
// Variables: see viewer_test.mjs.
import assert from "node:assert/strict";
import { mkdtemp, readdir, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import AxeBuilder from "@axe-core/playwright";
import { until } from "./viewer_page.mjs";
import { withPage, withStillPage } from "./with_page.mjs";

/** The place on the page of shares of the picture's width and height. */
async function placeOf(viewer, right, down) {
  const { x, y, width, height } = await viewer.page.locator("#picture").boundingBox();
  return [x + right * width, y + down * height];
}

async function clickAt(viewer, places) {
  for (const [right, down] of places) await viewer.page.mouse.click(...(await placeOf(viewer, right, down)));
}

async function tapAt(viewer, right, down) {
  const [x, y] = await placeOf(viewer, right, down);
  const devtools = await viewer.page.context().newCDPSession(viewer.page);
  await devtools.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [{ x, y }] });
  await devtools.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await devtools.detach();
}

const listed = (viewer) => viewer.page.locator("#measurement-list li").allInnerTexts();

async function listHas(viewer, count) {
  const all = await until(
    `${count} measurements`,
    () => listed(viewer),
    (items) => items.length === count,
  );
  return all.at(-1);
}

async function begin(viewer, panes) {
  await viewer.firstPicture();
  await viewer.page.keyboard.press(panes);
  await viewer.page.keyboard.press("m");
  await until(
    "a frozen picture",
    () => viewer.page.locator("#measured").textContent(),
    (text) => text.startsWith("Click the first of two points"),
  );
  await viewer.settled();
}

/** Millimetres of the picture's height. */
async function heightMm(viewer, panes) {
  return panes * (await viewer.field("camera.field_mm"));
}

test("a volume is measured by outlines in parallel planes, and goes to a file and a still", async () => {
  await withStillPage("measured-volume", async (viewer) => {
    await begin(viewer, "9");
    await clickAt(viewer, [[0.5, 0.5]]);
    await viewer.page.locator("#tomography-step").selectOption("10");
    await until(
      "a point that other planes cancel",
      () => viewer.page.locator("#measured").textContent(),
      (text) => text === "The picture has changed. Measure again.",
    );
    await viewer.page.locator("#tomography-step").selectOption("5");
    await viewer.settled();
    await viewer.page.locator("#measure-kind").selectOption("area");
    // The same square in the middle pane of each row: planes 1, 4 and 7 lie 15 mm apart.
    const [half, third] = [0.08, 1 / 3];
    for (const row of [0, 1, 2]) {
      const down = (row + 0.5) * third;
      const corners = [
        [0.5 - half, down - half],
        [0.5 + half, down - half],
        [0.5 + half, down + half],
        [0.5 - half, down + half],
      ];
      await clickAt(viewer, corners);
      if (row === 0) await viewer.page.locator("#close-outline").click();
      else await clickAt(viewer, [corners[0]]); // the first point closes it too
      await listHas(viewer, row + 1);
    }
    const { width, height } = await viewer.page.locator("#picture").boundingBox();
    const sideMm = 2 * half * (await heightMm(viewer, 3));
    const areaMm2 = sideMm ** 2 * (width / height);
    const area = Number(/([\d.]+) ± [\d.]+ cm² flat area/.exec((await listed(viewer))[0])[1]) * 100;
    assert.ok(Math.abs(area / areaMm2 - 1) < 0.03, `${area} mm², not ${areaMm2}`);

    await viewer.page.locator("#measure-volume").click();
    const volume = Number(/([\d.]+) ± [\d.]+ cm³/.exec(await listHas(viewer, 4))[1]);
    const trueCm3 = (areaMm2 * 45) / 1000;
    assert.ok(Math.abs(volume / trueCm3 - 1) < 0.03, `${volume} cm³, not ${trueCm3}`);

    await viewer.page.locator("#measurement-list input").last().fill("Cyst");
    await viewer.page.locator("#measurement-list input").last().press("Enter");
    await viewer.screenshot("measured-volume-list");
    const { violations } = await new AxeBuilder({ page: viewer.page })
      .setLegacyMode(true) // see controls_test.mjs
      .withTags(["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"])
      .include("#measurements")
      .include("#measuring")
      .analyze();
    assert.deepEqual(
      violations.map(({ id }) => id),
      [],
    );

    const download = viewer.page.waitForEvent("download");
    await viewer.page.locator("#save-measurements").click();
    const rows = (await readFile(await (await download).path(), "utf8")).trim().split("\r\n");
    assert.equal(rows.length, 1 + 3 * 2 + 1);
    assert.match(rows.at(-1), /^Cyst,volume,volume,[\d.]+,cm3,[\d.]+,"of the outlines 1, 2, 3",\d+,/);
    const still = viewer.page.waitForEvent("download");
    await viewer.page.keyboard.press("s");
    assert.match((await still).suggestedFilename(), /\.png$/);

    await viewer.page.locator("#measurement-list button").first().click();
    await listHas(viewer, 3);
    await viewer.page.locator("#forget-measurements").click();
    assert.equal((await listed(viewer)).length, 3, "the first click asks");
    await viewer.page.locator("#forget-measurements").click();
    assert.equal(await viewer.page.locator("#measurements").isVisible(), false);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("distances, angles and ellipses are measured in a plane, which shows them, and on the surface", async () => {
  await withStillPage("measured-planes", async (viewer) => {
    await begin(viewer, "4");
    const fieldMm = await heightMm(viewer, 1);
    const { width, height } = await viewer.page.locator("#picture").boundingBox();
    const mmPerHeight = 2 * fieldMm;
    // Plane A is at the upper left.
    await clickAt(viewer, [
      [0.15, 0.2],
      [0.15, 0.4],
    ]);
    const distance = Number(/([\d.]+) ± /.exec(await listHas(viewer, 1))[1]);
    assert.ok(Math.abs(distance - 0.2 * mmPerHeight) < 0.5, `${distance} mm, not ${0.2 * mmPerHeight}`);
    await viewer.page.locator("#measure-kind").selectOption("angle");
    // A point in another plane begins again; then three points in plane A.
    await clickAt(viewer, [
      [0.7, 0.2],
      [0.1, 0.1],
    ]);
    assert.match(await viewer.page.locator("#measured").textContent(), /begun again/);
    await viewer.page.locator("#take-back").click();
    await clickAt(viewer, [[0.1, 0.3]]);
    await viewer.page.locator("#picture").press("Escape");
    assert.equal(await viewer.page.locator("#take-back").isVisible(), false);
    const [right, down] = [0.1, (0.1 * width) / height];
    await clickAt(viewer, [
      [0.1 + right, 0.1],
      [0.1, 0.1],
      [0.1, 0.1 + down],
    ]);
    assert.match(await listHas(viewer, 2), /(89|90)\.\d ± [\d.]+°/);
    await viewer.page.locator("#measure-kind").selectOption("ellipse");
    const picture = viewer.page.locator("#picture");
    await picture.focus();
    // By keys: the cross begins in the middle, and is moved into plane A.
    const steps = (key, count) => Array.from({ length: count }, () => key);
    const keys = ["ArrowLeft", ...steps("Shift+ArrowLeft", 2), ...steps("Shift+ArrowUp", 2), "Enter"];
    for (const key of [...keys, "Shift+ArrowLeft", "Enter", "ArrowRight", "ArrowRight", "ArrowUp", "ArrowUp", "Enter"])
      await picture.press(key);
    assert.match(await listHas(viewer, 3), /mm circumference\s.* c?m?m² area/);
    const shown = () => viewer.page.locator("#measurement text").allTextContents();
    assert.equal((await shown()).length, 3);
    await viewer.screenshot("measured-planes-list");

    // Another plane: what was measured is not in it. The list keeps it.
    await viewer.page.locator('#planes [aria-label^="Plane A"]').first().focus();
    await viewer.page.keyboard.press("Shift+ArrowRight");
    await until("no measurement in another plane", shown, (texts) => texts.length === 0);
    assert.equal((await listed(viewer)).length, 3);
    // The plane through both points of the distance shows it again, at right angles to plane A.
    await viewer.page.locator("#measurement-list button.wide").click();
    await until("the distance in its plane", shown, (texts) => texts.length === 1 && texts[0].startsWith("1: "));
    assert.equal(await viewer.page.locator("#picture").getAttribute("aria-busy"), "false");
    await viewer.screenshot("measured-plane-through");
    await viewer.page.locator("#reset-view").click();
    await viewer.page.keyboard.press("1");
    await viewer.settled();
    await viewer.page.locator("#measure-kind").selectOption("angle");
    await clickAt(viewer, [
      [0.4, 0.5],
      [0.5, 0.5],
      [0.5, 0.4],
    ]);
    assert.match(await listHas(viewer, 4), /on the surface\s+[\d.]+ ± [\d.]+°/);
    await viewer.page.locator("#measure-kind").selectOption("area");
    await clickAt(viewer, [
      [0.4, 0.4],
      [0.6, 0.4],
      [0.5, 0.6],
    ]);
    await viewer.page.mouse.dblclick(...(await placeOf(viewer, 0.45, 0.55)));
    assert.match(await listHas(viewer, 5), /cm² flat area/);
    await viewer.screenshot("measured-surface-list");

    // By touch, in a plane: the distance of the beginning once more.
    await viewer.page.keyboard.press("4");
    await viewer.settled();
    await viewer.page.locator("#measure-kind").selectOption("distance");
    for (const down of [0.2, 0.4]) await tapAt(viewer, 0.15, down);
    const tapped = Number(/([\d.]+) ± /.exec(await listHas(viewer, 6))[1]);
    assert.ok(Math.abs(tapped - distance) < 0.5, `${tapped} mm by touch, ${distance} mm by mouse`);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

/** The cubic centimetres that the page says at the bottom. */
async function saidCm3(viewer) {
  const said = await until(
    "a volume",
    () => viewer.page.locator("#measured").textContent(),
    (text) => /[\d.]+ ± [\d.]+ cm³/.test(text) || text.startsWith("No volume"),
  );
  return Number(/^([\d.]+) ± /.exec(said)?.[1]);
}

test("fluid is measured from a point in it, and kept once its border is accepted", async () => {
  // A sphere of 20 mm radius around (0, 75, 0).
  const trueCm3 = ((4 / 3) * Math.PI * 20 ** 3) / 1000;
  await withPage("fluid-volume", "phantom:scene=cyst,volumes=1,rate=60", async (viewer) => {
    await begin(viewer, "4");
    await viewer.page.locator("#measure-kind").selectOption("fluid");
    const said = () => viewer.page.locator("#measured").textContent();
    assert.match(await said(), /Click inside the fluid in one of the planes/);
    const { width, height } = await viewer.page.locator("#picture").boundingBox();
    const mmPerHeight = await heightMm(viewer, 2);
    const target = [await viewer.field("camera.target_x_mm"), await viewer.field("camera.target_y_mm")];
    // Plane A: x to the right, depth downwards.
    const inPlaneA = (x, y) => [
      0.25 + ((x - target[0]) / mmPerHeight) * (height / width),
      0.25 + (y - target[1]) / mmPerHeight,
    ];
    await clickAt(viewer, [[0.75, 0.75]]);
    assert.match(await said(), /Click inside the fluid in one of the planes/, "not on the surface");
    await clickAt(viewer, [inPlaneA(4, 71)]);
    const cm3 = await saidCm3(viewer);
    assert.ok(Math.abs(cm3 / trueCm3 - 1) < 0.02, `${cm3} cm³, not ${trueCm3}`);
    const borders = viewer.page.locator("#measurement path.region");
    assert.equal(await borders.count(), 3, "planes A, B and C pass through it");
    await viewer.screenshot("fluid-border");
    // Where the border is drawn: the circle in which plane A cuts the sphere, of at most 40 mm.
    const drawnHeight = 512; // of the picture, in the units of what is drawn over it
    const acrossMm = ((await borders.first().evaluate((path) => path.getBBox().width)) / drawnHeight) * mmPerHeight;
    assert.ok(acrossMm > 30 && acrossMm < 41, `${acrossMm} mm across`);
    assert.equal(await viewer.page.locator("#measurements").isVisible(), false, "nothing is kept yet");

    const tighter = viewer.page.locator("#fluid-tighter");
    await tighter.focus();
    await viewer.page.keyboard.press("Enter");
    await until("a tighter border", said, (text) => text.includes("border 1.5 dB tighter"));
    assert.ok((await saidCm3(viewer)) < cm3);
    await viewer.page.locator("#fluid-wider").click();
    await until("the border before", said, (text) => /cm³\. Keep it/.test(text));
    assert.equal(await saidCm3(viewer), cm3);
    const { violations } = await new AxeBuilder({ page: viewer.page })
      .setLegacyMode(true) // see controls_test.mjs
      .withTags(["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"])
      .include("#measuring")
      .analyze();
    assert.deepEqual(
      violations.map(({ id }) => id),
      [],
    );
    await viewer.page.locator("#keep-fluid").focus();
    await viewer.page.keyboard.press("Enter");
    assert.match(await listHas(viewer, 1), new RegExp(`Fluid clicked in plane A\\s+${cm3.toFixed(2)} ± `));
    assert.equal(await viewer.page.locator("#fluid-bar").isVisible(), false);
    assert.equal(await viewer.page.evaluate(() => document.activeElement?.id), "measure-kind");
    assert.ok((await borders.count()) >= 1, "it stays in the planes");
    const download = viewer.page.waitForEvent("download");
    await viewer.page.locator("#save-measurements").click();
    const rows = (await readFile(await (await download).path(), "utf8")).trim().split("\r\n");
    assert.match(rows.at(-1), /^1,fluid,volume,3\d\.\d+,cm3,[\d.]+,clicked in plane A,\d+,/);

    await clickAt(viewer, [inPlaneA(24, 75)]);
    await until("a refusal", said, (text) => text.startsWith("No volume: this point is not in fluid"));
    await clickAt(viewer, [inPlaneA(0, 75)]);
    await saidCm3(viewer);
    const keep = viewer.page.locator("#keep-fluid");
    await viewer.page.keyboard.press("1");
    await until(
      "no border on show",
      () => keep.isDisabled(),
      (disabled) => disabled,
    );
    await viewer.page.keyboard.press("4");
    await until(
      "the border",
      () => keep.isDisabled(),
      (disabled) => !disabled,
    );
    await viewer.page.locator("#drop-fluid").click();
    assert.equal((await listed(viewer)).length, 1);
    assert.match(await said(), /Click inside the fluid in one of the planes/);
    // By keys: the cross begins in the middle, and is moved into plane A.
    const picture = viewer.page.locator("#picture");
    await picture.focus();
    await picture.press("ArrowLeft"); // shows it
    for (const key of ["Shift+ArrowLeft", "Shift+ArrowUp"])
      for (let step = 0; step < 3; ++step) await picture.press(key);
    await viewer.settled();
    await viewer.screenshot("fluid-by-keys");
    await picture.press("Enter");
    const again = await saidCm3(viewer);
    assert.ok(Math.abs(again / trueCm3 - 1) < 0.02, `${again} cm³ by keys`);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

/** A measurement on the first volume of a recording that ends with it, by two displays; the recording's path. */
async function measureWhileRecording(folder) {
  let file = "";
  const source = "phantom:scene=relief,probe=r1,columns=64,rows=64,rate=30";
  const steps = async (viewer, server) => {
    const post = (path, body) =>
      fetch(new URL(path, server.url), {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify(body),
      });
    const recording = async () => (await fetch(new URL("api/recording", server.url))).json();
    await viewer.firstPicture();
    file = (await (await post("api/recording", { wish: "start" })).json()).file;
    // Several sweeps, so that the one on show is whole in the recording.
    await until("three sweeps", recording, ({ frames }) => frames > 300);
    await begin(viewer, "4");
    await clickAt(viewer, [
      [0.15, 0.2],
      [0.15, 0.4],
    ]);
    await listHas(viewer, 1);
    const kept = viewer.page.locator("#measurements-kept");
    await until(
      "it is kept",
      () => kept.textContent(),
      (text) => text === "Kept on the server until it stops, and with each recording that holds their volume.",
    );
    const nameOn = (page) => page.page.locator("#measurement-list input");
    await nameOn(viewer).fill("Eye");
    await nameOn(viewer).press("Enter");
    const other = await server.openPage();
    try {
      await other.firstPicture();
      await listHas(other, 1);
      await until(
        "the name of the display that measured",
        () => nameOn(other).inputValue(),
        (value) => value === "Eye",
      );
      await nameOn(other).fill("Lens");
      await nameOn(other).press("Enter");
    } finally {
      await other.page.close();
    }
    const name = () => nameOn(viewer).inputValue();
    await until("the other display's name", name, (value) => value === "Lens");
    await viewer.page.reload();
    await viewer.firstPicture();
    await listHas(viewer, 1);
    assert.equal(await name(), "Lens");
    await until(
      "it is drawn after a reload",
      () => viewer.page.locator("#measurement text").allTextContents(),
      (texts) => texts.length === 1 && texts[0].startsWith("Lens: "),
    );
    await viewer.screenshot("measurement-kept");
    await post("api/recording", { wish: "stop" });
    await until("the end of the recording", recording, ({ last_file }) => last_file === file);
    await until(
      "its measurements",
      () => readdir(folder),
      (names) => names.includes(`${file}.measurements.json`),
    );
    assert.deepEqual(viewer.consoleProblems, []);
  };
  await withPage("measurement-recorded", source, steps, ["--recordings", folder]);
  return join(folder, file);
}

test("a measurement stays with the recording of its volume, for all displays", async () => {
  const folder = await mkdtemp(join(tmpdir(), "fanlight-measured-"));
  try {
    const path = await measureWhileRecording(folder);
    const replay = async (viewer) => {
      await viewer.firstPicture();
      assert.match(await listHas(viewer, 1), /Distance in plane A/);
      assert.equal(await viewer.page.locator("#measurements-kept").textContent(), "Kept with this recording.");
      await viewer.page.keyboard.press("4");
      await viewer.settled();
      const text = viewer.page.locator('[data-replay="text"]');
      await until(
        "the end",
        () => text.textContent(),
        (shown) => shown.endsWith("ended"),
      );
      await viewer.settled();
      const drawn = () => viewer.page.locator("#measurement text").allTextContents();
      assert.deepEqual(await drawn(), [], "on another volume");
      assert.match((await listed(viewer))[0], /frames \d+ to \d+/);
      await viewer.screenshot("measurement-elsewhere");
      await viewer.page.getByRole("button", { name: "Go to its volume" }).focus();
      await viewer.page.keyboard.press("Enter");
      await until("its volume", drawn, (texts) => /^Lens: [\d.]+ ± [\d.]+ mm/.test(texts[0] ?? ""));
      await viewer.screenshot("measurement-replayed");
      assert.deepEqual(viewer.consoleProblems, []);
    };
    await withPage("measurement-replay", path, replay, ["--ending", "once"]);
  } finally {
    await rm(folder, { recursive: true });
  }
});
