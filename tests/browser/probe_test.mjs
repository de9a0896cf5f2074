// The page of a probe, against the stand-in for the server, whose probe is unplugged when a test says so.
//   FANLIGHT_BIN           server/viewer/dev/fake_server.mjs (required)
//   FANLIGHT_ARTIFACTS     a folder for screenshots
//   CHROMIUM               the browser, if not /usr/bin/chromium
import assert from "node:assert/strict";
import { test } from "node:test";
import { until } from "./viewer_page.mjs";
import { withPage } from "./with_page.mjs";

const kProbe = "usb:1209:0001";

/** What a hand does to the cable. */
async function turn(server, command) {
  const { status } = await fetch(new URL(command, server.url), { method: "POST" });
  assert.equal(status, 204, command);
}

async function type(viewer, name, text) {
  const box = viewer.page.locator(`[data-number="${name}"]`);
  await box.fill(text);
  await box.press("Enter");
}

function fieldIs(viewer, name, expected) {
  return until(
    `${name} to be ${expected}`,
    () => viewer.field(name),
    (value) => value === expected,
  );
}

function noticeSays(viewer, pattern) {
  return until(
    `the notice ${pattern}`,
    () => viewer.page.locator("#notice").textContent(),
    (text) => pattern.test(text),
  );
}

async function isStale(viewer) {
  return /stale/.test(await viewer.page.locator("#frame").getAttribute("class"));
}

function isReadOnly(viewer) {
  return viewer.page.locator('[data-number="probe.depth_mm"]').evaluate((box) => box.readOnly);
}

/** Keeps all that the notice says, as one that goes by itself may be gone when the test looks. */
function listen(viewer) {
  return viewer.page.evaluate(() => {
    const notice = document.querySelector("#notice");
    window.noticed = [];
    new MutationObserver(() => window.noticed.push(notice.textContent)).observe(notice, {
      childList: true,
      subtree: true,
    });
  });
}

test("a probe is shown and set; what it rounds and what it refuses stands in the row", async () => {
  await withPage("probe", kProbe, async (viewer) => {
    await viewer.firstPicture();
    await viewer.unfold("probe");
    assert.equal(await viewer.page.locator('[data-probe="serial"]').textContent(), "0007");
    assert.equal(await viewer.field("probe.sweep_deg"), 70);

    await type(viewer, "probe.depth_mm", "141.5");
    await fieldIs(viewer, "probe.depth_mm", 140);
    const summary = await viewer.page.locator('[data-group="probe"] > summary').textContent();
    assert.match(summary, /70 deg, 35 frames, 140 mm/);

    await type(viewer, "probe.sweep_deg", "500");
    const sentence = await until(
      "a refusal",
      () => viewer.page.locator("#refusal").textContent(),
      (text) => text !== "",
    );
    assert.match(sentence, /sweep was to be 500 deg, expected 10 to 85 deg/);
    await fieldIs(viewer, "probe.sweep_deg", 70);

    await viewer.page.locator('[data-field="probe.frames_a_volume"]').focus();
    await viewer.page.keyboard.press("ArrowRight");
    await fieldIs(viewer, "probe.frames_a_volume", 36);
    await until(
      "the refusal to be over",
      () => viewer.page.locator("#refusal").isVisible(),
      (visible) => !visible,
    );

    await until(
      "what is left of the mismatch",
      () => viewer.stat("mismatch"),
      (text) => text === "corrected 1.02 deg, left 0.03 deg (0.06 mm)",
    );
    await until(
      "a count of interpolated volumes",
      () => viewer.number("volumes-interpolated"),
      (count) => count > 0,
    );
    // Only some pictures have the mark: it is looked for with every frame that the browser draws.
    await viewer.page.waitForFunction(() => {
      const mark = document.querySelector('[data-stat="frames-missing"]');
      return !mark.hidden && mark.textContent === "2 frames interpolated";
    });
    assert.deepEqual(viewer.complaints, []);
  });
});

test("a lost probe is told, to who comes later too, and its last picture is not taken for a living one", async () => {
  await withPage("probe-back", kProbe, async (viewer, server) => {
    await viewer.firstPicture();
    assert.equal(await isStale(viewer), false);
    await viewer.unfold("probe");
    await turn(server, "unplug");
    await noticeSays(viewer, /Probe lost.*Since \d\d:\d\d:\d\d\./);
    assert.ok(await isStale(viewer), "the last picture looks alive");
    assert.match(await viewer.page.locator("#not-live").textContent(), /^Not live, \d+ s old$/);
    assert.ok(await isReadOnly(viewer), "a lost probe can be set");

    // It can still be lit.
    await viewer.settled();
    const pass2 = await viewer.number("pass2-runs");
    await viewer.drag([0.3, 0.3], [0.7, 0.6]);
    await viewer.settled();
    assert.ok((await viewer.number("pass2-runs")) > pass2, "the last picture was not lit anew");
    assert.ok(await isStale(viewer), "a relit picture looks alive");
    await viewer.screenshot("probe-lost");

    await viewer.page.reload();
    await viewer.firstPicture();
    await noticeSays(viewer, /Probe lost.*Since about \d\d:\d\d:\d\d\./);
    assert.ok(await isStale(viewer), "the last picture looks alive to who comes later");

    await listen(viewer);
    await turn(server, "plug");
    await until(
      "the return to be told, and a living picture",
      async () => [await viewer.page.evaluate(() => window.noticed.join("\n")), await isStale(viewer)],
      ([said, stale]) => /Probe is back/.test(said) && !stale,
    );
    await until(
      "the notice of the return to go",
      () => viewer.page.locator("#notice").isVisible(),
      (visible) => !visible,
    );
    assert.equal(await viewer.page.locator("#not-live").isVisible(), false);
    assert.equal(await isReadOnly(viewer), false, "a probe that is back cannot be set");
    assert.deepEqual(viewer.complaints, []);
  });
});
