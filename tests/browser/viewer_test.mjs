// The page against a real server in a real browser.
//   FANLIGHT_BIN           the fanlight binary (required)
//   FANLIGHT_STILL_SOURCE  a source that gives one volume and then stands still
//   FANLIGHT_ARTIFACTS     a folder for screenshots
//   CHROMIUM               the browser, if not /usr/bin/chromium
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { Served } from "./served.mjs";
import { difference, launchChromium, until, ViewerPage } from "./viewer_page.mjs";

const kMovingSource = "phantom:rate=20,speckle=off";
const kStillSource = process.env.FANLIGHT_STILL_SOURCE ?? "phantom:volumes=1";
const kAnotherPicture = 4; // grey levels of 255, mean over the middle

let browser;
before(async () => {
  browser = await launchChromium();
});
after(() => browser?.close());

/** Runs the steps with a server and a page; whatever happens, takes a screenshot and ends both. */
async function withPage(name, source, steps) {
  let server = await Served.start(source);
  let viewer;
  try {
    viewer = await ViewerPage.open(browser, server.url);
    const restart = async () => {
      server = await Served.start(source, server.port);
    };
    await steps(viewer, { end: (signal) => server.end(signal), restart, url: server.url });
  } catch (error) {
    error.message += `\nthe page complained: ${JSON.stringify(viewer?.complaints)}\nthe server printed:\n${server.output}`;
    throw error;
  } finally {
    await viewer?.screenshot(name);
    await viewer?.page.close();
    await server.end();
  }
}

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
