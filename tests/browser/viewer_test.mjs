// The page against a real server in a real browser.
//   FANLIGHT_BIN           the fanlight binary (required)
//   FANLIGHT_STILL_SOURCE  a source that gives one volume and then stands still
//   FANLIGHT_ARTIFACTS     a folder for screenshots
//   CHROMIUM               the browser, if not /usr/bin/chromium
import assert from "node:assert/strict";
import { test } from "node:test";
import { difference, until } from "./viewer_page.mjs";
import { withPage } from "./with_page.mjs";

const kMovingSource = "phantom:rate=20,speckle=off";
// Slow enough for a busy machine to draw each frame in time: a volume that lacks a run of them is never shown.
const kStillSource = process.env.FANLIGHT_STILL_SOURCE ?? "phantom:volumes=1,rate=20";
const kAnotherPicture = 4; // grey levels of 255, mean over the middle

test("pictures arrive and advance, the status line fills in, and nothing else is asked for", async () => {
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
    assert.equal(await viewer.page.locator("#notice").isVisible(), false, "a notice covers a living picture");
    assert.equal(await viewer.page.locator('[data-group="probe"]').isVisible(), false, "a phantom is set as a probe");

    const host = new URL(server.url).host;
    const elsewhere = viewer.addresses.filter((address) => new URL(address).host !== host);
    assert.deepEqual(elsewhere, [], "requests to other hosts");
    assert.deepEqual(viewer.complaints, []);
  });
});

test("the light moves without ray casting; threshold and camera cast again", async () => {
  await withPage("moved", kStillSource, async (viewer) => {
    await viewer.firstPicture();
    await viewer.settled();

    const seen = async () => ({
      grey: await viewer.grey(),
      pass1: await viewer.number("pass1-runs"),
      pass2: await viewer.number("pass2-runs"),
      revision: await viewer.number("scene-revision"),
    });
    const atStart = await seen();
    await viewer.drag([0.2, 0.2], [0.85, 0.8]);
    await viewer.settled();
    const lit = await seen();
    const field_mm = await viewer.field("camera.field_mm");
    assert.ok(
      Math.abs((await viewer.field("light.up_mm")) - -0.3 * field_mm) < 0.02 * field_mm,
      "the light is not where it was dropped",
    );
    assert.ok(lit.revision > atStart.revision, `scene revision ${atStart.revision} -> ${lit.revision}`);
    assert.ok(
      difference(atStart.grey, lit.grey) > kAnotherPicture,
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
    const thresholded = await seen();
    assert.ok(thresholded.pass1 > lit.pass1, `pass 1 ran ${lit.pass1} -> ${thresholded.pass1} times`);

    const yaw_deg = await viewer.field("camera.yaw_deg");
    await viewer.drag([0.4, 0.5], [0.6, 0.55], "right");
    await viewer.settled();
    const orbited = await seen();
    assert.ok(Math.abs((await viewer.field("camera.yaw_deg")) - yaw_deg) > 10, "the drag did not turn the camera");
    assert.ok(difference(thresholded.grey, orbited.grey) > kAnotherPicture, "the turned picture is the same");
    assert.ok(orbited.pass1 > thresholded.pass1, "a turned camera did not run pass 1");
    assert.deepEqual(viewer.complaints, []);
  });
});

test("a refused value is told and taken back", async () => {
  await withPage("refused", kStillSource, async (viewer) => {
    await viewer.firstPicture();
    const threshold = await viewer.field("detector.threshold");
    const box = viewer.page.locator('[data-number="detector.threshold"]');
    await box.fill("999");
    await box.press("Enter");
    const sentence = await until(
      "a refusal",
      () => viewer.page.locator("#refusal").textContent(),
      (text) => text !== "",
    );
    assert.match(sentence, /threshold/);
    await until(
      "the value in force",
      () => viewer.field("detector.threshold"),
      (value) => value === threshold,
    );
  });
});

test("a number between a field's steps becomes the nearest of them", async () => {
  await withPage("stepped", kStillSource, async (viewer) => {
    await viewer.firstPicture();
    const box = viewer.page.locator('[data-number="filter.size"]');
    for (const [typed, taken] of [
      ["4.2", 5],
      ["-3", 1],
    ]) {
      await box.fill(typed);
      await box.press("Enter");
      await viewer.settled();
      assert.equal(await viewer.field("filter.size"), taken);
    }
    assert.deepEqual(viewer.complaints, []);
  });
});

test("a surface is coloured without ray casting, and gets its colour back", async () => {
  await withPage("coloured", kStillSource, async (viewer) => {
    await viewer.firstPicture();
    await viewer.settled();
    const warmth = await viewer.warmth();
    const pass1 = await viewer.number("pass1-runs");
    const red = await viewer.field("material.red");
    assert.ok(warmth > 0, `the surface is skin, red over blue ${warmth}`);
    await viewer.unfold("material");
    await viewer.page.locator('[data-colour="material.colour"]').fill("#2040ff");
    await viewer.settled();
    assert.ok((await viewer.warmth()) < -kAnotherPicture, `a blue surface has red over blue ${await viewer.warmth()}`);
    assert.deepEqual(
      [await viewer.field("material.red"), await viewer.field("material.green"), await viewer.field("material.blue")],
      [0.125, 0.251, 1],
    );
    await viewer.page.locator('[data-reset="material.colour"]').click();
    await viewer.settled();
    assert.equal(await viewer.field("material.red"), red);
    assert.ok(Math.abs((await viewer.warmth()) - warmth) < 1, "the colour did not come back");
    assert.equal(await viewer.number("pass1-runs"), pass1, "a colour ran pass 1");
    assert.deepEqual(viewer.complaints, []);
  });
});

test("the volume is recoloured by hand and by text, and a text that is none is refused", async () => {
  await withPage("transfer", kStillSource, async (viewer) => {
    await viewer.firstPicture();
    assert.ok(await viewer.unused("transfer"), "the volume's colours count in mode surface");
    await viewer.choose("mode", "volume");
    await viewer.unfold("transfer");
    await viewer.settled();
    assert.equal(await viewer.unused("transfer"), false, "the volume's colours do not count in mode volume");
    assert.ok(await viewer.unused("light"), "the light counts in mode volume");
    const points = () => viewer.text("transfer.points");
    const atFirst = await points();
    const handles = viewer.page.locator("[data-handle]");
    const count = atFirst.split(",").length;
    assert.equal(await handles.count(), count);

    // A point by double click, dragged elsewhere, moved by keys, coloured, and removed again.
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
    const [dragged, , lowered] = (await points()).split(", ").at(-2).split(" ").map(Number);
    assert.ok(dragged < level - 15 && lowered < opacity - 0.05, `${await points()} after a drag`);
    await viewer.page.keyboard.press("ArrowRight");
    await viewer.page.keyboard.press("Shift+ArrowRight");
    await viewer.settled();
    assert.match(await points(), new RegExp(`, ${dragged + 11} #`));
    await viewer.page.locator('[data-point="colour"]').fill("#0000ff");
    await viewer.settled();
    assert.match(await points(), new RegExp(`, ${dragged + 11} #0000ff `));
    await viewer.page.locator('[data-point="remove"]').click();
    await viewer.settled();
    assert.equal(await points(), atFirst);

    const text = viewer.page.locator('[data-text="transfer.points"]');
    const cold = "0 #0000ff 0, 30 #0000ff 0.4, 255 #0000ff 0.5";
    await text.fill(cold);
    await text.press("Enter");
    await viewer.settled();
    assert.equal(await points(), cold);
    assert.ok((await viewer.warmth()) < -kAnotherPicture, `a blue volume has red over blue ${await viewer.warmth()}`);

    await text.fill("0 #0000ff 0, nonsense");
    await text.press("Enter");
    const sentence = await until(
      "a refusal",
      () => viewer.page.locator("#refusal").textContent(),
      (said) => said !== "",
    );
    assert.match(sentence, /transfer\.points.*expected/);
    await until("the text in force", points, (shown) => shown === cold);
    assert.deepEqual(viewer.complaints, []);
  });
});

test("the light is moved where the surface is, and nowhere without one", async () => {
  await withPage("slices", kStillSource, async (viewer) => {
    await viewer.firstPicture();
    await viewer.choose("mode", "slices");
    await viewer.settled();
    // The lower right quarter, whose centre is at three quarters.
    const to = [0.85, 0.65];
    await viewer.drag([0.7, 0.8], to);
    await viewer.settled();
    const field_mm = await viewer.field("camera.field_mm");
    const near = (value, expected) => Math.abs(value - expected) < 0.02 * field_mm;
    assert.ok(near(await viewer.field("light.right_mm"), 0.2 * field_mm), `${await viewer.field("light.right_mm")} mm`);
    assert.ok(near(await viewer.field("light.up_mm"), 0.2 * field_mm), `${await viewer.field("light.up_mm")} mm`);
    const follows = async (place) => {
      const [x, y] = await viewer.marker();
      assert.ok(Math.hypot(x - place[0], y - place[1]) < 0.02, `the marker is at ${x}, ${y}, not ${place}`);
    };
    await follows(to);

    // In perspective the lamp, nearer than the target, moves less for the same drag; the pointer holds it.
    await viewer.unfold("camera");
    await viewer.choose("camera.projection", "perspective");
    await viewer.drag([0.7, 0.8], to);
    await viewer.settled();
    await follows(to);
    assert.ok((await viewer.field("light.up_mm")) < 0.19 * field_mm, `${await viewer.field("light.up_mm")} mm`);

    await viewer.choose("mode", "slice");
    await viewer.settled();
    assert.equal(await viewer.marker(), null, "a light is shown in a slice");
    assert.ok(await viewer.page.locator('#tools input[value="light"]').isDisabled());
    assert.ok(await viewer.page.locator('[data-number="slice.depth_mm"]').isVisible());
    assert.equal(await viewer.page.locator('[data-number="detector.threshold"]').isVisible(), false);
    const up_mm = await viewer.field("light.up_mm");
    const yaw_deg = await viewer.field("camera.yaw_deg");
    await viewer.drag([0.4, 0.5], [0.6, 0.55]);
    await viewer.settled();
    assert.equal(await viewer.field("light.up_mm"), up_mm, "an unseen light was moved");
    assert.notEqual(await viewer.field("camera.yaw_deg"), yaw_deg, "the drag did not turn the slice");

    await viewer.page.locator('[data-reset="all"]').click();
    await viewer.settled();
    assert.equal(await viewer.page.locator('#tools input[value="light"]').isChecked(), true);
    assert.deepEqual(viewer.complaints, []);
  });
});

test("a setting without an effect says so and can be set all the same", async () => {
  await withPage("unused", kStillSource, async (viewer) => {
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
    assert.deepEqual(viewer.complaints, []);
  });
});

test("a killed server is told, and its successor shown without a reload", async () => {
  await withPage("recovered", kMovingSource, async (viewer, server) => {
    await viewer.firstPicture();
    await viewer.page.evaluate(() => {
      window.notReloaded = true;
    });
    await server.end("SIGKILL");
    await until(
      "the page to say that the connection is lost",
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
      "a living picture",
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
