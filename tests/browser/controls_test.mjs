// SPDX-License-Identifier: Apache-2.0
// Tests the controls in reach in Chromium against the real server, by mouse, keys and touch. Variables: see
// viewer_test.mjs.
import assert from "node:assert/strict";
import { test } from "node:test";
import { setTimeout as pause } from "node:timers/promises";
import AxeBuilder from "@axe-core/playwright";
import { until } from "./viewer_page.mjs";
import { withPage, withStillPage } from "./with_page.mjs";

const kMovingSource = "phantom:scene=relief,probe=r1,frames=18,rate=20,speckle=off";

const wordOf = (viewer) => viewer.page.locator("#connection [role=status]").textContent();
const press = (viewer, key) => viewer.page.keyboard.press(key);
const click = (viewer, selector) => viewer.page.locator(selector).click();
const isPressed = async (viewer, selector) =>
  (await viewer.page.locator(selector).getAttribute("aria-pressed")) === "true";

function waitForWord(viewer, word) {
  return until(
    `the state ${word}`,
    () => wordOf(viewer),
    (text) => text === word,
  );
}

/** Waits for pictures of the probe. Beside other tests they may be delayed, which liveness_test.mjs tests. */
function waitForPictures(viewer) {
  return until(
    "pictures of the probe",
    () => wordOf(viewer),
    (text) => text === "Simulated" || text === "Delayed",
  );
}

/** Closes the group that ViewerPage opens. */
async function closeAdvanced(viewer) {
  await viewer.page.locator("#advanced > summary").click();
}

/** Opens the page as a phone of this size shows it. */
async function onPhone(viewer, width, height, steps) {
  const context = await viewer.page
    .context()
    .browser()
    .newContext({ viewport: { width, height }, hasTouch: true, isMobile: true });
  try {
    const page = await context.newPage();
    await page.goto(viewer.page.url());
    await page.locator("#picture").waitFor({ state: "visible" });
    await steps(page, await context.newCDPSession(page));
  } finally {
    await context.close();
  }
}

test("the controls in reach are few, and statistics come at a key", async () => {
  await withStillPage("in-reach", async (viewer) => {
    await viewer.firstPicture();
    await closeAdvanced(viewer);
    const visible = await viewer.page.locator("input:visible, select:visible, button:not(.banner *):visible").count();
    assert.ok(visible <= 46, `${visible} controls at rest`);
    assert.equal(await viewer.page.locator("#statistics").isVisible(), false);
    await press(viewer, "i");
    assert.equal(await viewer.page.locator("#statistics").isVisible(), true);
    assert.equal(await viewer.page.locator("#plots figure").count(), 3);
    await press(viewer, "i");
    assert.equal(await viewer.page.locator("#statistics").isVisible(), false);
    assert.equal(await viewer.page.locator("#source").textContent(), "Phantom (simulated)");
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a frozen picture stays, the last volumes are stepped through, and the light still moves", async () => {
  await withPage("frozen", kMovingSource, async (viewer) => {
    await waitForPictures(viewer);
    await until(
      "some volumes",
      () => viewer.number("volume-id"),
      (id) => id >= 5,
    );
    await press(viewer, " ");
    await waitForWord(viewer, "Frozen");
    assert.match(await viewer.page.locator("#not-live").textContent(), /^Frozen, \d+ s old$/);
    assert.equal(await viewer.page.locator("#frame.stale").count(), 0, "a frozen picture is dimmed");
    await viewer.settled();
    const frozen = await viewer.number("volume-id");
    await press(viewer, ",");
    await press(viewer, ",");
    await until(
      "an older volume",
      () => viewer.number("volume-id"),
      (id) => id === frozen - 2,
    );
    assert.match(await viewer.page.locator('[data-cine="text"]').textContent(), /^volume \d+ of \d+, .* before/);
    const pass1 = await viewer.number("pass1-runs");
    await viewer.drag([0.2, 0.2], [0.7, 0.7]);
    await viewer.settled();
    assert.equal(await viewer.number("volume-id"), frozen - 2);
    assert.equal(await viewer.number("pass1-runs"), pass1, "a moved light ran pass 1");
    await viewer.screenshot("frozen");
    await click(viewer, '[data-cine="freeze"]');
    await waitForPictures(viewer);
    await until(
      "a newer volume",
      () => viewer.number("volume-id"),
      (id) => id > frozen,
    );
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("presets, sliders and panes change the picture, and undo and redo take that back and forth", async () => {
  await withStillPage("presets", async (viewer) => {
    await viewer.firstPicture();
    assert.ok(await isPressed(viewer, '[data-preset="face"]'));
    await click(viewer, '[data-preset="bone"]');
    await viewer.settled();
    assert.ok(await isPressed(viewer, '[data-preset="bone"]'));
    assert.equal(await viewer.page.locator('[data-field="detector.sign"]').inputValue(), "1");
    const mark = viewer.page.locator("#near-tissue-mark");
    await mark.waitFor({ state: "visible" });
    assert.equal(await mark.textContent(), "Near tissue removed", "no skull, but fluid below the reverberation");
    await press(viewer, "z");
    await viewer.settled();
    assert.ok(await isPressed(viewer, '[data-preset="face"]'), "undo does not bring the preset back");
    await press(viewer, "y");
    await viewer.settled();
    assert.ok(await isPressed(viewer, '[data-preset="bone"]'), "redo does not make the preset again");
    await click(viewer, "#undo");
    const smoothing = viewer.page.locator('[data-quick="filter.size_mm"]');
    const smoothed = await viewer.field("filter.size_mm");
    await smoothing.focus();
    for (let step = 0; step < 4; ++step) await smoothing.press("ArrowRight");
    await viewer.settled();
    assert.notEqual(await viewer.field("filter.size_mm"), smoothed);
    await click(viewer, "#undo");
    await viewer.settled();
    assert.equal(await viewer.field("filter.size_mm"), smoothed, "the steps of a key are not one change");
    await click(viewer, '[data-preset="baby"]');
    assert.equal(await viewer.field("light.haze"), 0.008);
    await click(viewer, '[data-preset="face"]');
    assert.equal(await viewer.field("light.haze"), 0.004);
    const legend = viewer.page.locator("#depth-legend");
    assert.ok(await legend.isHidden());
    await click(viewer, '[data-preset="depth"]');
    await legend.waitFor({ state: "visible" });
    const end_mm = await viewer.field("rays.end_mm");
    assert.equal(await legend.locator("span:nth-child(5)").textContent(), String(Math.round(end_mm)));
    await press(viewer, "z");
    const target = await viewer.field("camera.distance_mm");
    for (const [place, isBehind] of [
      ["front", false],
      ["behind", true],
    ]) {
      await viewer.page.getByRole("button", { name: `Light ${place}` }).click();
      assert.equal((await viewer.field("light.depth_mm")) > target, isBehind, place);
    }
    await press(viewer, "z");
    await press(viewer, "z");

    const slide = (field, value) => viewer.page.locator(`[data-quick="${field}"]`).fill(String(value));
    await viewer.settled();
    const opaque = await viewer.greyLevels();
    await click(viewer, '[data-preset="silhouette"]');
    await viewer.changedFrom(opaque, 15, "the preset Silhouette");
    assert.equal(await viewer.page.locator('[data-quick="glass.amount"]').inputValue(), "100");
    await slide("glass.amount", 0);
    await viewer.settled();
    const clearer = await viewer.greyLevels();
    await slide("glass.amount", 60);
    await viewer.changedFrom(clearer, 5, "the slider of glass");
    await click(viewer, '[data-preset="face"]');
    assert.equal(await viewer.field("glass.amount"), 0);
    await slide("shadow.coefficient", 0);
    await slide("finish.exposure", 75);
    await slide("filter.size_mm", 25);
    await viewer.settled();
    assert.equal(await viewer.field("shadow.coefficient"), 1, "no shadow leaves all light");
    assert.equal(await viewer.field("filter.size_mm"), 3);
    assert.equal(await viewer.field("finish.exposure"), 4.09);
    await slide("detector.threshold", 30);
    await viewer.settled();
    assert.equal(await viewer.field("detector.threshold"), 30);
    await click(viewer, ".quick button");
    await viewer.settled();
    assert.equal(await viewer.field("detector.threshold"), 0, "Auto takes the threshold from the data");

    await press(viewer, "4");
    await viewer.settled();
    assert.equal(await viewer.page.locator("#pane-names").isVisible(), true);
    const { x, y, width, height } = await viewer.page.locator("#picture").boundingBox();
    await viewer.page.mouse.dblclick(x + 0.75 * width, y + 0.75 * height);
    await until(
      "one pane",
      () => viewer.page.locator('#layout input[value="surface"]').isChecked(),
      (checked) => checked,
    );
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("Steady averages volumes, and the picture says how many", async () => {
  await withPage("steady", "phantom:scene=face,moving=off,probe=r1,frames=18,rate=40", async (viewer) => {
    const slider = viewer.page.locator('[data-quick="filter.steady"]');
    const mark = viewer.page.locator("#steady-mark");
    const output = slider.locator("xpath=../output");
    assert.equal(await output.textContent(), "off");
    assert.ok(await mark.isHidden());
    await slider.focus();
    for (let volumes = 2; volumes <= 5; ++volumes) await press(viewer, "ArrowRight");
    assert.equal(await output.textContent().then((text) => text.split(",")[0]), "up to 5 volumes");
    await until(
      "the mark",
      () => mark.textContent(),
      (text) => /teady over [345] volumes$/.test(text),
    );
    assert.equal(await viewer.field("filter.steady"), 0.8);
    const { x, y, width, height } = await slider.boundingBox();
    await viewer.page.mouse.click(x + 2, y + height / 2);
    await until(
      "one volume",
      () => mark.isHidden(),
      (hidden) => hidden,
    );
    await viewer.page.mouse.click(x + width - 2, y + height / 2);
    assert.equal(await output.textContent().then((text) => text.split(",")[0]), "up to 8 volumes");
    await onPhone(viewer, 390, 844, async (page) => {
      await page.locator("#steady-mark").waitFor({ state: "visible" });
    });
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("only Turn resets the view at a double click; Pan shifts it", async () => {
  await withStillPage("tools", async (viewer) => {
    await viewer.firstPicture();
    await click(viewer, '[data-view="90 0"]');
    await viewer.settled();
    const { x, y, width, height } = await viewer.page.locator("#picture").boundingBox();
    const doubleClick = () => viewer.page.mouse.dblclick(x + width / 2, y + height / 2);
    await doubleClick();
    await viewer.settled();
    assert.equal(await viewer.field("camera.yaw_deg"), 90, "a double click while Light is chosen reset the view");
    await press(viewer, "t");
    await doubleClick();
    await viewer.settled();
    assert.equal(await viewer.field("camera.yaw_deg"), 0);

    await press(viewer, "p");
    const before = await viewer.field("camera.target_x_mm");
    const fieldMm = await viewer.field("camera.field_mm");
    await viewer.drag([0.3, 0.5], [0.5, 0.5]);
    await viewer.settled();
    const moved = before - (await viewer.field("camera.target_x_mm"));
    assert.ok(Math.abs(moved - 0.2 * fieldMm) < 1, `the target moved by ${moved} mm, not ${0.2 * fieldMm}`);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a distance is measured on a frozen surface only, straight and along it", async () => {
  await withPage("measured", kMovingSource, async (viewer) => {
    await waitForPictures(viewer);
    await press(viewer, "m");
    const said = () => viewer.page.locator("#measured").textContent();
    assert.match(await said(), /freezes the picture|first of two points/, "Measure freezes the picture");
    await waitForWord(viewer, "Frozen");
    await viewer.settled();
    const { x, y, width, height } = await viewer.page.locator("#picture").boundingBox();
    const measure = async () => {
      // The volume that was being drawn when the picture froze may be shown after the first clicks, which it cancels.
      if (/first of two points|Measure again/.test(await said())) {
        for (const share of [0.4, 0.6]) await viewer.page.mouse.click(x + share * width, y + 0.4 * height);
      }
      return said();
    };
    const sentence = await until("a distance", measure, (text) => / mm straight/.test(text));
    const [straight, along] = sentence.match(/[\d.]+(?= ± [\d.]+ mm)/g).map(Number);
    const fieldMm = await viewer.field("camera.field_mm");
    assert.ok(straight >= 0.2 * fieldMm - 0.5 && straight < 0.5 * fieldMm, sentence);
    assert.ok(along >= straight, sentence);
    assert.match(sentence, /Not for diagnosis\.$/);
    assert.ok((await viewer.page.locator("#measurement path").count()) >= 3, "the measurement is not drawn");
    const saved = viewer.page.waitForEvent("download");
    await press(viewer, "s");
    assert.match((await saved).suggestedFilename(), /^fanlight-.*\.png$/);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("settings are found by their words, and a refusal can be closed", async () => {
  await withStillPage("found-setting", async (viewer) => {
    await viewer.firstPicture();
    const search = viewer.page.locator("#find-setting");
    await search.fill("softness");
    assert.equal(await viewer.page.locator("#controls .row:visible").count(), 1);
    await search.fill("no such words");
    assert.equal(await viewer.page.locator("#no-setting").isVisible(), true);
    await search.fill("");
    assert.equal(await viewer.page.locator('[data-number="shadow.softness_mm"]').isVisible(), false);
    const box = viewer.page.locator('[data-number="camera.field_mm"]');
    await viewer.unfold("camera");
    await box.fill("999999");
    await box.press("Enter");
    await viewer.page.locator("#refusal").waitFor({ state: "visible" });
    await click(viewer, "#refusal button");
    assert.equal(await viewer.page.locator("#refusal").isVisible(), false);
  });
});

test("on a phone the picture comes first, and a scroll that begins on a slider sets nothing", async () => {
  await withStillPage("phone", async (viewer) => {
    await viewer.firstPicture();
    for (const [width, height, share] of [
      [390, 844, 0.4],
      [844, 390, 0.2],
    ]) {
      await onPhone(viewer, width, height, async (page, devtools) => {
        const picture = await page.locator("#picture").boundingBox();
        const shown = (picture.width * picture.height) / (width * height);
        assert.ok(shown > share, `the picture has ${shown} of a screen of ${width} x ${height}`);
        await page.locator("#show-panel").tap();
        const slider = page.locator('[data-quick="filter.size_mm"]');
        await slider.scrollIntoViewIfNeeded();
        const box = await slider.boundingBox();
        const touch = async (type, x, y) => {
          await pause(30); // a hand is no faster
          await devtools.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x, y }] });
        };
        const [x, y] = [box.x + 0.9 * box.width, box.y + box.height / 2];
        await touch("touchStart", x, y);
        for (let step = 1; step <= 6; ++step) await touch("touchMove", x, y - 8 * step);
        await touch("touchEnd");
        assert.equal(await slider.inputValue(), "50", "a scroll moved the slider");
        assert.equal(await viewer.field("filter.size_mm"), 6, "a scroll changed the scene");
        await pause(500); // the panel may still glide
        await slider.scrollIntoViewIfNeeded();
        const after = await slider.boundingBox();
        const middle = after.y + after.height / 2;
        await touch("touchStart", after.x + 0.5 * after.width, middle);
        for (let step = 1; step <= 6; ++step) {
          await touch("touchMove", after.x + (0.5 - 0.05 * step) * after.width, middle);
          if (step === 1) await pause(800); // a hand may rest: its drag is one change all the same
        }
        await touch("touchEnd");
        const dragged = Number(await slider.inputValue());
        assert.ok(dragged < 40, `a drag along the slider moved it to ${dragged}`);
        await page.locator("#undo").tap();
        await until(
          "the undone smoothing",
          () => viewer.field("filter.size_mm"),
          (size_mm) => size_mm === 6,
        );
        const small = await page
          .locator("button:visible, select:visible, #toolbar label:visible")
          .evaluateAll((targets) =>
            targets
              .filter((target) => target.getBoundingClientRect().height < 43.5)
              .map((target) => target.textContent),
          );
        assert.deepEqual(small, [], "targets of less than 44 pixels");
      });
    }
  });
});

test("three lights have handles, which the mouse, keys and a finger move, and a panel", async () => {
  await withStillPage("lights", async (viewer) => {
    const { page } = viewer;
    await viewer.firstPicture();
    const marker = async (lamp) => {
      const light = await page.locator(`[data-lamp=${lamp}]`).boundingBox();
      const picture = await page.locator("#picture").boundingBox();
      return (
        light && [
          (light.x + light.width / 2 - picture.x) / picture.width,
          (light.y + light.height / 2 - picture.y) / picture.height,
        ]
      );
    };
    assert.equal(await marker("fill_light"), null, "a light that is off has a handle");
    const pass1 = await viewer.number("pass1-runs");
    const keyOnly = await viewer.greyLevels();
    await page.locator("#lamps > summary").click();
    await page.locator("#lamp-choice").getByText("Fill").click();
    await page.locator("#lamp-on").check();
    await viewer.changedFrom(keyOnly, 0.5, "the fill light");
    assert.equal(await page.locator("#lamps-on").textContent(), "key, fill");
    await page.locator("#lamp-strength").fill("90");
    await page.locator("#lamp-colour").fill("#0000ff");
    await viewer.settled();
    assert.equal(await viewer.field("fill_light.strength"), 0.9);
    assert.equal(await viewer.field("fill_light.red"), 0);

    // A light that is switched off stays the one that the panel shows.
    await page.locator("#lamp-on").uncheck();
    await viewer.settled();
    const isOn = () => page.locator('[data-field="fill_light.on"]').inputValue();
    assert.equal(await isOn(), "0");
    assert.ok(await page.locator("#lamp-choice").getByLabel("Fill").isChecked(), "the panel shows another light");
    await page.getByRole("button", { name: "Light side" }).click();
    await viewer.settled();
    assert.equal(await isOn(), "1", "a light that is placed is not switched on");

    // The handle of the key light is taken by the mouse, though the fill light was chosen.
    const [key_mm, fill_mm] = [await viewer.field("light.right_mm"), await viewer.field("fill_light.right_mm")];
    await viewer.drag(await marker("light"), [0.5, 0.3]);
    await viewer.settled();
    assert.ok(Math.abs(await viewer.field("light.right_mm")) < 2, "the handle of the key light did not move it");
    assert.notEqual(await viewer.field("light.right_mm"), key_mm);
    assert.equal(await viewer.field("fill_light.right_mm"), fill_mm);
    assert.ok(await page.locator("#lamp-choice").getByLabel("Key").isChecked(), "a dragged light is not chosen");

    await page.locator("#lamp-choice").getByText("Fill").click();
    await page.locator("#picture").focus();
    await press(viewer, "ArrowUp");
    await viewer.settled();
    const up_mm = await viewer.field("fill_light.up_mm");
    await press(viewer, "ArrowUp");
    await viewer.settled();
    assert.ok((await viewer.field("fill_light.up_mm")) > up_mm, "the arrow key did not move the chosen light");
    assert.equal(await viewer.number("pass1-runs"), pass1, "a light ran pass 1");

    const devtools = await page.context().newCDPSession(page);
    const touch = (type, ...touchPoints) => devtools.send("Input.dispatchTouchEvent", { type, touchPoints });
    const handle = await page.locator("[data-lamp=light]").boundingBox();
    const picture = await page.locator("#picture").boundingBox();
    await touch("touchStart", { x: handle.x + handle.width / 2 + 8, y: handle.y + handle.height / 2 });
    for (const part of [0.55, 0.6, 0.65, 0.7]) {
      await touch("touchMove", { x: picture.x + part * picture.width, y: picture.y + 0.6 * picture.height });
    }
    await touch("touchEnd");
    await until(
      "the key light that a finger moved",
      () => viewer.field("light.right_mm"),
      (right_mm) => right_mm > 10,
    );
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("nothing violates the accessibility rules A and AA, at rest, with all groups open, frozen and lost", async () => {
  await withPage("accessible", kMovingSource, async (viewer, server) => {
    await waitForPictures(viewer);
    // Axe opens a blank page for its results, which this browser's context does not allow: legacy mode does not.
    const check = async (state) => {
      const { violations } = await new AxeBuilder({ page: viewer.page })
        .setLegacyMode(true)
        .withTags(["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"])
        .analyze();
      const told = violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target).join(", ")}`);
      assert.deepEqual(told, [], state);
    };
    await closeAdvanced(viewer);
    await check("at rest");
    await closeAdvanced(viewer); // opens it again
    await viewer.page.locator("#controls").evaluate((form) => {
      for (const group of form.querySelectorAll("details")) group.open = true;
    });
    await press(viewer, "i");
    await viewer.page.locator("#own-presets").evaluate((details) => (details.open = true));
    await viewer.page.locator("#lamps").evaluate((details) => (details.open = true));
    await press(viewer, "4");
    await press(viewer, "c");
    await check("with all groups open, four panes and the crop box");
    await press(viewer, "1");
    await press(viewer, "l");
    await press(viewer, " ");
    await waitForWord(viewer, "Frozen");
    await check("frozen");
    await server.end("SIGKILL");
    await waitForWord(viewer, "Lost");
    await check("lost");
  });
});
