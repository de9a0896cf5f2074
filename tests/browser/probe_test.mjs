// SPDX-License-Identifier: Apache-2.0
// Tests the page with a probe against the viewer's fake server, which unplugs its probe on request.
//   FANLIGHT_BIN           server/viewer/dev/fake_server.mjs (required)
//   FANLIGHT_ARTIFACTS     a folder for screenshots
//   CHROMIUM               the browser, if not /usr/bin/chromium
import assert from "node:assert/strict";
import { test } from "node:test";
import { until } from "./viewer_page.mjs";
import { withPage } from "./with_page.mjs";

const kProbe = "usb:1209:0001";

/** Makes the fake server "plug" or "unplug" its probe. */
async function sendProbeCommand(server, command) {
  const { status } = await fetch(new URL(command, server.url), { method: "POST" });
  assert.equal(status, 204, command);
}

/** Types the text into a number field and presses Enter. */
async function enterNumber(viewer, name, text) {
  const box = viewer.page.locator(`[data-number="${name}"]`);
  await box.fill(text);
  await box.press("Enter");
}

function waitForField(viewer, name, expected) {
  return until(
    `${name} to be ${expected}`,
    () => viewer.field(name),
    (value) => value === expected,
  );
}

function waitForNotice(viewer, pattern) {
  return until(
    `the notice to match ${pattern}`,
    () => viewer.page.locator("#notice").textContent(),
    (text) => pattern.test(text),
  );
}

/** Whether the page marks the picture as not live. */
async function isStale(viewer) {
  return /stale/.test(await viewer.page.locator("#frame").getAttribute("class"));
}

/** The state of the picture comes in a message of its own, after that of the probe. */
async function untilLost(viewer) {
  await until(
    "the mark of a lost picture",
    () => viewer.page.locator("#not-live").textContent(),
    (mark) => /^Lost, \d+ s old$/.test(mark),
  );
  assert.ok(await isStale(viewer), "the lost picture is not marked as stale");
}

/** Whether the depth setting of the probe is read-only. */
function isReadOnly(viewer) {
  return viewer.page.locator('[data-number="probe.depth_mm"]').evaluate((box) => box.readOnly);
}

/**
 * Records every text of the notice in window.recordedNotices. A notice that hides itself may otherwise be gone before
 * the test reads it.
 */
function recordNotices(viewer) {
  return viewer.page.evaluate(() => {
    const notice = document.querySelector("#notice");
    window.recordedNotices = [];
    new MutationObserver(() => window.recordedNotices.push(notice.textContent)).observe(notice, {
      childList: true,
      subtree: true,
    });
  });
}

test("the page sets the probe and shows rounded values, refused values and loss statistics", async () => {
  await withPage("probe", kProbe, async (viewer) => {
    await viewer.firstPicture();
    await viewer.unfold("probe");
    assert.equal(await viewer.page.locator('[data-probe="serial"]').textContent(), "0007");
    assert.equal(await viewer.field("probe.sweep_deg"), 70);

    await enterNumber(viewer, "probe.depth_mm", "141.5");
    await waitForField(viewer, "probe.depth_mm", 140);
    const summary = await viewer.page.locator('[data-group="probe"] > summary').textContent();
    assert.match(summary, /70 deg, 35 frames, 140 mm/);

    await enterNumber(viewer, "probe.sweep_deg", "500");
    const sentence = await until(
      "the text of the refusal",
      () => viewer.page.locator("#refusal > span").textContent(),
      (text) => text !== "",
    );
    assert.match(sentence, /sweep was to be 500 deg, expected 10 to 85 deg/);
    await waitForField(viewer, "probe.sweep_deg", 70);

    await viewer.page.locator('[data-field="probe.frames_a_volume"]').focus();
    await viewer.page.keyboard.press("ArrowRight");
    await waitForField(viewer, "probe.frames_a_volume", 36);
    await until(
      "the refusal to be hidden",
      () => viewer.page.locator("#refusal").isVisible(),
      (visible) => !visible,
    );

    await until(
      "the remaining mismatch",
      () => viewer.stat("mismatch"),
      (text) => text === "corrected 1.02 deg, left 0.03 deg (0.06 mm)",
    );
    await until(
      "a count of interpolated volumes",
      () => viewer.number("volumes-interpolated"),
      (count) => count > 0,
    );
    // Only some pictures show the mark. waitForFunction checks with every frame that the browser draws.
    await viewer.page.waitForFunction(() => {
      const mark = document.querySelector('[data-stat="frames-missing"]');
      return !mark.hidden && /^4 of \d+ frames interpolated$/.test(mark.textContent);
    });
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("the page reports a lost probe, also after a reload, marks its last picture as stale, and recovers", async () => {
  await withPage("probe-back", kProbe, async (viewer, server) => {
    await viewer.firstPicture();
    assert.equal(await isStale(viewer), false);
    await viewer.unfold("probe");
    await sendProbeCommand(server, "unplug");
    await waitForNotice(viewer, /Probe lost.*Since \d\d:\d\d:\d\d\./);
    await untilLost(viewer);
    assert.ok(await isReadOnly(viewer), "the settings of a lost probe can be changed");

    // The light of the last picture can still be moved.
    await viewer.settled();
    const pass2 = await viewer.number("pass2-runs");
    await viewer.drag([0.3, 0.3], [0.7, 0.6]);
    await viewer.settled();
    assert.ok((await viewer.number("pass2-runs")) > pass2, "the moved light did not run pass 2 on the last picture");
    assert.ok(await isStale(viewer), "the last picture with a moved light is not marked as stale");
    await viewer.screenshot("probe-lost");

    await viewer.page.reload();
    await viewer.firstPicture();
    await waitForNotice(viewer, /Probe lost.*Since about \d\d:\d\d:\d\d\./);
    await untilLost(viewer);

    await recordNotices(viewer);
    await sendProbeCommand(server, "plug");
    await until(
      "a notice of the return and a live picture",
      async () => [await viewer.page.evaluate(() => window.recordedNotices.join("\n")), await isStale(viewer)],
      ([notices, stale]) => /Probe is back/.test(notices) && !stale,
    );
    await until(
      "the notice of the return to be hidden",
      () => viewer.page.locator("#notice").isVisible(),
      (visible) => !visible,
    );
    assert.equal(await viewer.page.locator("#not-live").isVisible(), false);
    assert.equal(await isReadOnly(viewer), false, "the settings of the returned probe cannot be changed");
    assert.deepEqual(viewer.consoleProblems, []);
  });
});
