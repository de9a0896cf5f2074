// SPDX-License-Identifier: Apache-2.0
// Tests the scalpel in Chromium against the real server, by mouse, keys and touch. Variables: see viewer_test.mjs.
import assert from "node:assert/strict";
import { test } from "node:test";
import { until } from "./viewer_page.mjs";
import { withStillPage } from "./with_page.mjs";

/** Where the lassos of the tests lie, in shares of the picture's width and height. */
const kPlace = [0.5, 0.5];
const kRadius = 0.1;

const press = (viewer, key) => viewer.page.keyboard.press(key);

/** Points around a place, the first one last again. */
function around([x, y], radius = kRadius, points = 16) {
  return Array.from({ length: points }, (_, at) => {
    const angle = (2 * Math.PI * at) / (points - 1);
    return [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
  });
}

async function onPage(viewer, [x, y]) {
  const box = await viewer.page.locator("#picture").boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

async function drag(viewer, places) {
  const { mouse } = viewer.page;
  await mouse.move(...(await onPage(viewer, places[0])));
  await mouse.down();
  for (const place of places.slice(1)) await mouse.move(...(await onPage(viewer, place)));
  await mouse.up();
}

/** The grey level of the picture at a place. */
function level(viewer, [x, y] = kPlace) {
  return viewer.page.locator("#picture").evaluate(
    (canvas, at) => {
      const copy = new OffscreenCanvas(1, 1).getContext("2d");
      copy.drawImage(canvas, -Math.floor(at[0] * canvas.width), -Math.floor(at[1] * canvas.height));
      const [red, green, blue] = copy.getImageData(0, 0, 1, 1).data;
      return (red + green + blue) / 3;
    },
    [x, y],
  );
}

const kHaze = 10; // grey level where there is no surface, in the default look
const isDark = (viewer, place) =>
  until(
    "a picture without what was cut",
    () => level(viewer, place),
    (now) => now < kHaze + 2,
  );
const isLit = (viewer, place) =>
  until(
    "a picture with the surface",
    () => level(viewer, place),
    (now) => now > 20,
  );
const cuts = (viewer, number) =>
  until(
    `${number} cuts`,
    () => viewer.text("cuts.shapes"),
    (text) => text.split(";").filter(Boolean).length === number,
  );

test("a lasso cuts away what it surrounds, in the planes too, and all of it is restored", async () => {
  await withStillPage("scalpel", async (viewer) => {
    await viewer.firstPicture();
    await viewer.unfold("cuts");
    const mark = viewer.page.locator("#cut-mark");
    await isLit(viewer);
    assert.equal(await mark.isVisible(), false);
    await press(viewer, "x");
    await drag(viewer, around(kPlace));
    await isDark(viewer);
    await isLit(viewer, [0.5, 0.75]);
    assert.equal(await mark.textContent(), "Cut away: 1 part");
    await viewer.page.locator("#cut-shape").selectOption("outside");
    await drag(viewer, around(kPlace, 0.2));
    await isDark(viewer, [0.5, 0.75]);
    await isLit(viewer, [0.5, 0.65]);
    await cuts(viewer, 2);
    await press(viewer, "z");
    await isLit(viewer, [0.5, 0.75]);
    await isDark(viewer);
    await press(viewer, "y");
    await isDark(viewer, [0.5, 0.75]);
    // The line of the cut is blue; planes are grey.
    await press(viewer, "4");
    await viewer.settled();
    await until(
      "the cut in a plane",
      async () => (await viewer.colours()).filter(([red, , blue]) => blue > red + 30).length,
      (blue) => blue > 5,
    );
    await viewer.screenshot("scalpel-planes");
    await press(viewer, "1");
    await viewer.page.locator("#restore-all").click();
    await isLit(viewer);
    await mark.waitFor({ state: "hidden" });
    await cuts(viewer, 0);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a depth, a ball, keys, touch and pictures of the server", async () => {
  await withStillPage("scalpel-depth", async (viewer) => {
    await viewer.firstPicture();
    await viewer.unfold("cuts");
    await viewer.settled();
    await press(viewer, "x");
    // The surface has no other behind it within 40 mm of depth, so the lasso ends in the tissue.
    await viewer.page.locator("#cut-depth").selectOption("40");
    await drag(viewer, around(kPlace));
    await cuts(viewer, 1);
    const [, nearest, farthest] = (await viewer.text("cuts.shapes")).split(" ").map(Number);
    assert.equal(nearest, -3000);
    const deepest = farthest + (await viewer.field("camera.distance_mm")); // below the view plane
    assert.ok(deepest > 45 && deepest < 150, `it cuts to ${deepest} mm`);
    await isDark(viewer);
    await viewer.page.locator("#restore-all").click();
    await cuts(viewer, 0);
    await isLit(viewer);
    await viewer.settled();

    await viewer.page.locator("#cut-shape").selectOption("ball");
    await viewer.page.locator("#cut-radius").selectOption("15");
    await drag(viewer, [
      [0.4, 0.5],
      [0.45, 0.5],
      [0.5, 0.5],
      [0.55, 0.5],
    ]);
    await cuts(viewer, 1);
    assert.match(await viewer.text("cuts.shapes"), /^balls 15 at /);
    await press(viewer, "z");
    await cuts(viewer, 0);
    await viewer.settled();

    // Where the server draws the pictures, it is asked for the surface.
    await viewer.page.locator("#codec").selectOption("0");
    await viewer.settled();
    await viewer.page.mouse.click(...(await onPage(viewer, kPlace)));
    await cuts(viewer, 1);
    // However quick the hand is, balls lie close to each other, on the surface that was there before the stroke.
    await viewer.page.locator("#cut-radius").selectOption("3");
    await drag(viewer, [
      [0.3, 0.6],
      [0.5, 0.6],
    ]);
    await cuts(viewer, 2);
    const centres = await until(
      "a row of balls",
      async () => {
        const numbers = (await viewer.text("cuts.shapes")).split(";")[1].split(" at ")[1].split(" ").map(Number);
        return Array.from({ length: numbers.length / 3 }, (_, at) => numbers.slice(3 * at, 3 * at + 3));
      },
      (balls) => balls.length >= 10,
    );
    for (const [at, [x, y]] of centres.slice(1).entries()) {
      assert.ok(Math.abs(x - centres[at][0]) < 3, `balls at ${centres[at][0]} and ${x} mm`);
      assert.ok(Math.abs(y - centres[at][1]) < 4, `a ball is ${y - centres[at][1]} mm behind the one before`);
    }
    await viewer.page.locator("#restore-all").click();
    await cuts(viewer, 0);

    await viewer.page.locator("#cut-shape").selectOption("inside");
    await viewer.page.locator("#cut-depth").selectOption("0");
    const picture = viewer.page.locator("#picture");
    await picture.focus();
    const keys = [["ArrowLeft", "ArrowUp"], ["ArrowRight", "ArrowRight"], ["ArrowDown", "ArrowDown"], ["ArrowLeft"]];
    await picture.press("ArrowLeft"); // shows the cross
    for (const moves of keys) {
      for (const key of moves) await picture.press(`Shift+${key}`);
      await picture.press("Enter");
    }
    await picture.press("Enter"); // the last corner again closes it
    await cuts(viewer, 1);
    await isDark(viewer, [0.49, 0.51]);
    await viewer.page.locator("#restore-all").click();
    await isLit(viewer);

    const devtools = await viewer.page.context().newCDPSession(viewer.page);
    const touch = async (type, place) => {
      const [x, y] = await onPage(viewer, place);
      await devtools.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x, y }] });
    };
    const places = around(kPlace);
    await touch("touchStart", places[0]);
    for (const place of places.slice(1)) await touch("touchMove", place);
    await touch("touchEnd", places[0]);
    await isDark(viewer);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a display that is not in control does not cut", async () => {
  await withStillPage("scalpel-refused", async (viewer, server) => {
    await viewer.firstPicture();
    await viewer.settled();
    const other = await server.openPage();
    await other.firstPicture();
    await viewer.drag([0.5, 0.5], [0.45, 0.45]); // it is in control now
    await until(
      "control of the first",
      () => other.page.locator("#control").textContent(),
      (text) => /control/.test(text) && !/^You/.test(text),
    );
    await press(other, "x");
    await drag(other, around(kPlace));
    const refusal = other.page.locator("#refusal");
    await refusal.waitFor({ state: "visible" });
    assert.match(await refusal.textContent(), /not in control/);
    assert.equal(await other.text("cuts.shapes"), "");
    await other.page.close();
    assert.deepEqual(viewer.consoleProblems, []);
  });
});
