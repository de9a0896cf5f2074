// SPDX-License-Identifier: Apache-2.0
// Tests the page in Chromium against the real server.
//   FANLIGHT_BIN           the fanlight binary (required)
//   FANLIGHT_STILL_SOURCE  a source that delivers one volume and no further ones
//   FANLIGHT_ARTIFACTS     a folder for screenshots
//   CHROMIUM               the browser, if not /usr/bin/chromium
import assert from "node:assert/strict";
import { test } from "node:test";
import { difference, until } from "./viewer_page.mjs";
import { withPage, withStillPage } from "./with_page.mjs";

// At this rate a busy machine generates each frame in time. A volume that lacks several frames in a row is never shown.
const kMovingSource = "phantom:scene=relief,probe=r1,frames=18,rate=20,speckle=off";
const kMinChangedDifference = 4; // mean grey levels of 255; pictures of different scenes differ by more

test("the page shows a stream of pictures and a complete status line, and contacts no other host", async () => {
  await withPage("living", kMovingSource, async (viewer, server) => {
    const first = await viewer.firstPicture();
    await until(
      "the picture id to advance",
      () => viewer.number("picture-id"),
      (id) => id > first,
    );
    const volume = await viewer.number("volume-id");
    await until(
      "the volume id to advance",
      () => viewer.number("volume-id"),
      (id) => id > volume,
    );
    await until(
      "a picture rate",
      () => viewer.number("pictures-per-second"),
      (rate) => rate > 0,
    );
    await until(
      "a picture age",
      () => viewer.number("picture-age-ms"),
      (age_ms) => age_ms > 0 && age_ms < 60_000,
    );
    for (const name of ["frames-lost", "pictures-skipped", "pass1-runs", "pass2-runs", "scene-revision"]) {
      await until(
        `a number for ${name}`,
        () => viewer.stat(name),
        (text) => /^\d+$/.test(text),
      );
    }
    await until(
      "stage times",
      () => viewer.stat("stages"),
      (text) => / ms/.test(text),
    );
    assert.notEqual(await viewer.stat("device"), "–");
    assert.equal(await viewer.page.locator("#notice").isVisible(), false, "a notice covers a live picture");
    assert.equal(
      await viewer.page.locator('[data-group="probe"]').isVisible(),
      false,
      "the phantom has probe settings",
    );

    const host = new URL(server.url).host;
    const toOtherHosts = viewer.requestedUrls.filter((url) => new URL(url).host !== host);
    assert.deepEqual(toOtherHosts, [], "requests to other hosts");
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a moved light does not run ray casting; a changed threshold or camera does", async () => {
  await withStillPage("moved", async (viewer) => {
    await viewer.firstPicture();
    await viewer.settled();

    const readState = async () => ({
      grey: await viewer.greyLevels(),
      pass1: await viewer.number("pass1-runs"),
      pass2: await viewer.number("pass2-runs"),
      revision: await viewer.number("scene-revision"),
    });
    const atStart = await readState();
    await viewer.drag([0.2, 0.2], [0.85, 0.8]);
    await viewer.settled();
    const lit = await readState();
    const field_mm = await viewer.field("camera.field_mm");
    assert.ok(
      Math.abs((await viewer.field("light.up_mm")) - -0.3 * field_mm) < 0.02 * field_mm,
      "the light is not where the drag ended",
    );
    assert.ok(lit.revision > atStart.revision, `scene revision ${atStart.revision} -> ${lit.revision}`);
    assert.ok(
      difference(atStart.grey, lit.grey) > kMinChangedDifference,
      `the picture changed by ${difference(atStart.grey, lit.grey)}`,
    );
    assert.equal(lit.pass1, atStart.pass1, "a moved light ran pass 1");
    assert.ok(lit.pass2 > atStart.pass2, `pass 2 ran ${atStart.pass2} -> ${lit.pass2} times`);

    await viewer.page.locator("#picture").focus();
    const up_mm = await viewer.field("light.up_mm");
    await viewer.page.keyboard.press("ArrowUp");
    await viewer.settled();
    assert.ok((await viewer.field("light.up_mm")) > up_mm, "the arrow key did not move the light");
    assert.equal(await viewer.number("pass1-runs"), atStart.pass1, "a moved light ran pass 1");

    await viewer.page.locator('[data-field="detector.threshold"]').focus();
    await viewer.page.keyboard.press("ArrowRight");
    await viewer.settled();
    const thresholded = await readState();
    assert.ok(thresholded.pass1 > lit.pass1, `pass 1 ran ${lit.pass1} -> ${thresholded.pass1} times`);

    const yaw_deg = await viewer.field("camera.yaw_deg");
    await viewer.drag([0.4, 0.5], [0.6, 0.55], "right");
    await viewer.settled();
    const orbited = await readState();
    assert.ok(Math.abs((await viewer.field("camera.yaw_deg")) - yaw_deg) > 10, "the drag did not turn the camera");
    assert.ok(difference(thresholded.grey, orbited.grey) > kMinChangedDifference, "the turned picture is the same");
    assert.ok(orbited.pass1 > thresholded.pass1, "a turned camera did not run pass 1");
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("the page shows a refusal and restores the value in force", async () => {
  await withStillPage("refused", async (viewer) => {
    await viewer.firstPicture();
    const threshold = await viewer.field("detector.threshold");
    const box = viewer.page.locator('[data-number="detector.threshold"]');
    await box.fill("999");
    await box.press("Enter");
    const sentence = await until(
      "the text of the refusal",
      () => viewer.page.locator("#refusal > span").textContent(),
      (text) => text !== "",
    );
    assert.match(sentence, /^Threshold is 999, expected/);
    await until(
      "the value in force",
      () => viewer.field("detector.threshold"),
      (value) => value === threshold,
    );
  });
});

test("the page shows the measured threshold, keeps it at a click, and finds the surface", async () => {
  await withStillPage("found", async (viewer) => {
    await viewer.firstPicture();
    assert.equal(await viewer.field("detector.threshold"), 0);
    const measured = viewer.page.locator('.measured:has([data-keep="detector.threshold"])');
    await measured.waitFor({ state: "visible" });
    assert.match(await measured.textContent(), /^Now [0-9.]+, from the data: fluid [0-9.]+, tissue [0-9.]+\./);
    await viewer.page.locator('[data-keep="detector.threshold"]').click();
    await viewer.settled();
    const kept = await viewer.field("detector.threshold");
    assert.ok(kept > 5 && kept < 60, `${kept} grey levels`);
    assert.equal(await measured.isVisible(), false);

    await viewer.page.locator("#find-surface").click();
    await viewer.page.locator("#found").waitFor({ state: "visible" });
    assert.match(await viewer.page.locator("#found").textContent(), /^Found a sheet of \d+ x \d+ mm/);
    await viewer.settled();
    assert.notEqual(await viewer.field("detector.threshold"), kept);
    assert.ok((await viewer.field("rays.end_mm")) < 120, "the rays end behind the surface");
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a click on a plane moves the other planes, and not the view plane of the surface", async () => {
  await withStillPage("slice-click", async (viewer) => {
    await viewer.firstPicture();
    await viewer.choose("mode", "slices");
    await viewer.settled();
    const field = (name) => viewer.field(name);
    const [targetX, targetY] = [await field("camera.target_x_mm"), await field("camera.target_y_mm")];
    const [distance, start] = [await field("camera.distance_mm"), await field("rays.start_mm")];
    // In the upper left pane, by a quarter of its width to the right of its middle, and by as much above.
    const { x, y, width, height } = await viewer.page.locator("#picture").boundingBox();
    await viewer.page.mouse.click(x + 0.375 * width, y + 0.125 * height);
    await viewer.settled();
    const quarterMm = (await field("camera.field_mm")) / 4;
    const near = (actual, expected) => assert.ok(Math.abs(actual - expected) < 1, `${actual} mm, not ${expected}`);
    near(await field("camera.target_x_mm"), targetX + quarterMm);
    near(await field("camera.target_y_mm"), targetY - quarterMm);
    near(await field("camera.distance_mm"), distance - quarterMm);
    near(await field("rays.start_mm"), start);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("the page rounds a typed number to the nearest step of its field", async () => {
  await withStillPage("stepped", async (viewer) => {
    await viewer.firstPicture();
    await viewer.unfold("filter");
    const box = viewer.page.locator('[data-number="filter.size"]');
    for (const [typed, rounded] of [
      ["4.2", 5],
      ["-3", 1],
    ]) {
      await box.fill(typed);
      await box.press("Enter");
      await viewer.settled();
      assert.equal(await viewer.field("filter.size"), rounded);
    }
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a surface colour is set and reset without ray casting", async () => {
  await withStillPage("coloured", async (viewer) => {
    await viewer.firstPicture();
    await viewer.settled();
    const skin = await viewer.redMinusBlue();
    const pass1 = await viewer.number("pass1-runs");
    const red = await viewer.field("material.red");
    assert.ok(skin > 0, `the default surface has the colour of skin; red minus blue is ${skin}`);
    await viewer.unfold("material");
    await viewer.page.locator('[data-colour="material.colour"]').fill("#2040ff");
    await viewer.settled();
    assert.ok(
      (await viewer.redMinusBlue()) < -kMinChangedDifference,
      `red minus blue of a blue surface is ${await viewer.redMinusBlue()}`,
    );
    assert.deepEqual(
      [await viewer.field("material.red"), await viewer.field("material.green"), await viewer.field("material.blue")],
      [0.125, 0.251, 1],
    );
    await viewer.page.locator('[data-reset="material.colour"]').click();
    await viewer.settled();
    assert.equal(await viewer.field("material.red"), red);
    assert.ok(Math.abs((await viewer.redMinusBlue()) - skin) < 1, "the colour did not come back");
    assert.equal(await viewer.number("pass1-runs"), pass1, "a changed colour ran pass 1");
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("the transfer function is edited by mouse, keys and text, and an invalid text is refused", async () => {
  await withStillPage("transfer", async (viewer) => {
    await viewer.firstPicture();
    assert.ok(await viewer.unused("transfer"), "the transfer function is in use in mode surface");
    await viewer.choose("mode", "volume");
    await viewer.unfold("transfer");
    await viewer.settled();
    assert.equal(await viewer.unused("transfer"), false, "the transfer function is unused in mode volume");
    assert.ok(await viewer.unused("light"), "the light is in use in mode volume");
    const points = () => viewer.text("transfer.points");
    const initialPoints = await points();
    const handles = viewer.page.locator("[data-handle]");
    const count = initialPoints.split(",").length;
    await handles.first().waitFor(); // the editor is loaded when it is first seen
    assert.equal(await handles.count(), count);

    // Adds a point by double click, drags it, moves it with keys, sets its colour, and removes it.
    const plot = viewer.page.locator(".transfer svg");
    await plot.scrollIntoViewIfNeeded();
    const box = await plot.boundingBox();
    await viewer.page.mouse.dblclick(box.x + box.width * 0.6, box.y + box.height * 0.3);
    await viewer.settled();
    assert.equal(await handles.count(), count + 1);
    const [level, , opacity] = (await points()).split(", ").at(-2).split(" ").map(Number);
    assert.ok(level > 120 && level < 170 && opacity > 0.3 && opacity < 0.8, await points());
    await viewer.page.mouse.move(box.x + box.width * 0.6, box.y + box.height * 0.3);
    await viewer.page.mouse.down();
    await viewer.page.mouse.move(box.x + box.width * 0.5, box.y + box.height * 0.5, { steps: 6 });
    await viewer.page.mouse.up();
    await viewer.settled();
    const [draggedLevel, , draggedOpacity] = (await points()).split(", ").at(-2).split(" ").map(Number);
    assert.ok(draggedLevel < level - 15 && draggedOpacity < opacity - 0.05, `${await points()} after a drag`);
    await viewer.page.keyboard.press("ArrowRight");
    await viewer.page.keyboard.press("Shift+ArrowRight");
    await viewer.settled();
    assert.match(await points(), new RegExp(`, ${draggedLevel + 11} #`));
    await viewer.page.locator('[data-point="colour"]').fill("#0000ff");
    await viewer.settled();
    assert.match(await points(), new RegExp(`, ${draggedLevel + 11} #0000ff `));
    await viewer.page.locator('[data-point="remove"]').click();
    await viewer.settled();
    assert.equal(await points(), initialPoints);

    const text = viewer.page.locator('[data-text="transfer.points"]');
    const blueTransfer = "0 #0000ff 0, 30 #0000ff 0.4, 255 #0000ff 0.5";
    await text.fill(blueTransfer);
    await text.press("Enter");
    await viewer.settled();
    assert.equal(await points(), blueTransfer);
    assert.ok(
      (await viewer.redMinusBlue()) < -kMinChangedDifference,
      `red minus blue of a blue volume is ${await viewer.redMinusBlue()}`,
    );

    await text.fill("0 #0000ff 0, nonsense");
    await text.press("Enter");
    const sentence = await until(
      "the text of the refusal",
      () => viewer.page.locator("#refusal > span").textContent(),
      (shown) => shown !== "",
    );
    assert.match(sentence, /^Volume colours: Points: .*expected/);
    await until("the text in force", points, (shown) => shown === blueTransfer);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("nine planes have their distances, a step and a direction, and a click moves the middle one", async () => {
  await withStillPage("tomography", async (viewer) => {
    await viewer.firstPicture();
    await viewer.page.keyboard.press("9");
    await viewer.settled();
    const names = () => viewer.page.locator("#tomography-names span").allTextContents();
    assert.deepEqual([(await names())[0], (await names())[4]], ["A \u221220 mm", "A 0 mm"]);
    await viewer.page.locator("#tomography-plane").selectOption("2");
    await viewer.page.locator("#tomography-step").selectOption("10");
    await viewer.settled();
    assert.equal((await names())[8], "C +40 mm");
    // In planes at constant depth the probe's depth points into the picture, whatever the camera.
    assert.equal(await viewer.page.locator("#axes circle.depth").count(), 1);
    assert.equal(await viewer.page.locator("#axes path.sweep").count(), 1);
    const depth_mm = await viewer.field("camera.target_y_mm");
    const box = await viewer.page.locator("#picture").boundingBox();
    await viewer.page.mouse.click(box.x + box.width / 6, box.y + box.height / 2);
    await viewer.settled();
    assert.equal(await viewer.field("camera.target_y_mm"), depth_mm - 10);
    await viewer.page.keyboard.press("1");
    await viewer.settled();
    assert.ok(await viewer.page.locator("#tomography").isHidden());
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("the light can be moved in modes with a surface, and its marker follows the pointer", async () => {
  await withStillPage("slices", async (viewer) => {
    await viewer.firstPicture();
    await viewer.choose("mode", "slices");
    await viewer.settled();
    // Mode slices shows the surface in the lower right quarter; its centre is at (0.75, 0.75).
    const end = [0.85, 0.65];
    await viewer.drag([0.7, 0.8], end);
    await viewer.settled();
    const field_mm = await viewer.field("camera.field_mm");
    const near = (value, expected) => Math.abs(value - expected) < 0.02 * field_mm;
    assert.ok(near(await viewer.field("light.right_mm"), 0.2 * field_mm), `${await viewer.field("light.right_mm")} mm`);
    assert.ok(near(await viewer.field("light.up_mm"), 0.2 * field_mm), `${await viewer.field("light.up_mm")} mm`);
    const checkMarkerAt = async (expected) => {
      const [x, y] = await viewer.lightMarker();
      assert.ok(
        Math.hypot(x - expected[0], y - expected[1]) < 0.02,
        `the marker is at ${x}, ${y}, expected ${expected}`,
      );
    };
    await checkMarkerAt(end);

    // In perspective projection the light is nearer than the target. The same drag moves it by fewer millimetres, and the
    // marker stays under the pointer.
    await viewer.unfold("camera");
    await viewer.choose("camera.projection", "perspective");
    await viewer.drag([0.7, 0.8], end);
    await viewer.settled();
    await checkMarkerAt(end);
    assert.ok((await viewer.field("light.up_mm")) < 0.19 * field_mm, `${await viewer.field("light.up_mm")} mm`);

    await viewer.choose("mode", "slice");
    await viewer.settled();
    assert.equal(await viewer.lightMarker(), null, "the light marker is shown in mode slice");
    assert.ok(await viewer.page.locator('#tools input[value="light"]').isDisabled());
    assert.ok(await viewer.page.locator('[data-number="slice.depth_mm"]').isVisible());
    assert.equal(await viewer.page.locator('[data-number="detector.threshold"]').isVisible(), false);
    const up_mm = await viewer.field("light.up_mm");
    const yaw_deg = await viewer.field("camera.yaw_deg");
    await viewer.drag([0.4, 0.5], [0.6, 0.55]);
    await viewer.settled();
    assert.equal(await viewer.field("light.up_mm"), up_mm, "a hidden light was moved");
    assert.notEqual(await viewer.field("camera.yaw_deg"), yaw_deg, "the drag did not turn the slice");

    await viewer.page.locator('[data-reset="all"]').click();
    await viewer.settled();
    assert.equal(await viewer.page.locator('#tools input[value="light"]').isChecked(), true);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("the page marks a setting that has no effect, and the setting can be changed", async () => {
  await withStillPage("unused", async (viewer) => {
    await viewer.firstPicture();
    await viewer.unfold("finish");
    const needs = viewer.page.locator('[id="finish.iterations-needs"]');
    assert.equal(await needs.textContent(), "No effect unless smoothing is diffusion.");
    const box = viewer.page.locator('[data-number="finish.iterations"]');
    await box.fill("7");
    await box.press("Enter");
    await viewer.choose("finish.smoothing", "diffusion");
    await viewer.settled();
    assert.equal(await needs.isVisible(), false);
    assert.equal(await viewer.field("finish.iterations"), 7);
    assert.match(await viewer.page.locator('[data-group="finish"] > summary').textContent(), /2 changed/);
    await viewer.page.locator('[data-reset="finish"]').click();
    await viewer.settled();
    assert.equal(await viewer.field("finish.iterations"), 5);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("the page reports a killed server and shows the restarted one without a reload", async () => {
  await withPage("recovered", kMovingSource, async (viewer, server) => {
    await viewer.firstPicture();
    await viewer.page.evaluate(() => {
      window.notReloaded = true;
    });
    await server.end("SIGKILL");
    await until(
      "the notice of the lost connection",
      () => viewer.page.locator("#notice").textContent(),
      (text) => /Connection lost/.test(text),
    );
    await viewer.screenshot("lost");
    await server.restart();
    await until(
      "the connection to come back",
      () => viewer.connection(),
      (state) => state === "open",
    );
    await until(
      "a live picture",
      () => viewer.page.locator("#frame").getAttribute("class"),
      (text) => !/stale/.test(text),
    );
    const id = await viewer.number("picture-id");
    await until(
      "the picture id to advance",
      () => viewer.number("picture-id"),
      (next) => next > id,
    );
    assert.equal(await viewer.page.evaluate(() => window.notReloaded), true, "the page was reloaded");
  });
});
