// SPDX-License-Identifier: Apache-2.0
// Tests the planes and the crop box of the page in Chromium against the real server: lines, handles and scales over the
// four panes. Variables: see viewer_test.mjs.
import assert from "node:assert/strict";
import { test } from "node:test";
import { difference, placeOf, until } from "./viewer_page.mjs";
import { withStillPage } from "./with_page.mjs";

const press = (viewer, key) => viewer.page.keyboard.press(key);
const click = (viewer, selector) => viewer.page.locator(selector).click();
const grip = (viewer, line, nth) => viewer.page.locator(`#planes [data-line="${line}"]`).nth(nth);

/** Drags from a point of the page by a way; `expected` waits for what that changes. */
async function dragFrom(viewer, { x, y }, right, down) {
  const { mouse } = viewer.page;
  await mouse.move(x, y);
  await mouse.down();
  await mouse.move(x + right / 2, y + down / 2, { steps: 4 });
  await mouse.move(x + right, y + down, { steps: 4 });
  await mouse.up();
}

/** A point of a line's grip, a share of its length from its start. */
async function pointOf(locator, share) {
  const { x, y, width, height } = await placeOf(locator);
  return width > height ? { x: x + share * width, y: y + height / 2 } : { x: x + width / 2, y: y + share * height };
}

function reaches(viewer, field, value, least = 1) {
  return until(
    `${field} near ${value}`,
    () => viewer.field(field),
    (now) => Math.abs(now - value) < least,
  );
}

test("the lines of four panes move the planes, and the panes have depth scales", async () => {
  await withStillPage("planes", async (viewer) => {
    await viewer.firstPicture();
    await press(viewer, "4");
    await viewer.settled();
    const { height } = await viewer.page.locator("#picture").boundingBox();
    const mmPerPixel = (await viewer.field("camera.field_mm")) / (height / 2);
    const x = await viewer.field("camera.target_x_mm");
    const y = await viewer.field("camera.target_y_mm");
    // Pane A: the first line is plane B, across; the second one C, in depth.
    await dragFrom(viewer, await pointOf(grip(viewer, "plane plane-B", 0), 0.2), 30, 0);
    await reaches(viewer, "camera.target_x_mm", x + 30 * mmPerPixel);
    await dragFrom(viewer, await pointOf(grip(viewer, "plane plane-C", 0), 0.2), 0, -20);
    await reaches(viewer, "camera.target_y_mm", y - 20 * mmPerPixel);
    const ticks = await viewer.page.locator("#planes text.depth").allTextContents();
    assert.ok(ticks.length >= 6 && ticks.some((text) => / mm$/.test(text)), ticks.join());
    await press(viewer, "1");
    await viewer.settled();
    assert.equal(await viewer.page.locator("#planes .grip").count(), 0);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

/** Grey levels of the middle of pane A, 80 pixels to each side, by column and row from the middle. */
function paneA(viewer) {
  return viewer.page.locator("#picture").evaluate((canvas) => {
    const size = 160;
    const copy = new OffscreenCanvas(size, size).getContext("2d", { willReadFrequently: true });
    copy.drawImage(canvas, size / 2 - canvas.width / 4, size / 2 - canvas.height / 4);
    const { data } = copy.getImageData(0, 0, size, size);
    return Array.from({ length: size * size }, (_, pixel) => data[4 * pixel]);
  });
}

/** What a picture of paneA() is after a quarter of a turn, counterclockwise. */
function turnedLeft(levels) {
  const size = Math.sqrt(levels.length);
  return levels.map((_, pixel) => levels[(pixel % size) * size + (size - 1 - Math.floor(pixel / size))]);
}

test("a handle turns the planes, and a button turns them back", async () => {
  await withStillPage("turned-planes", async (viewer) => {
    await viewer.firstPicture();
    await press(viewer, "4");
    await viewer.settled();
    const straight = await paneA(viewer);
    const names = () => viewer.page.locator("#pane-names span").allTextContents();
    assert.match((await names())[0], /in the plane of a frame/);
    assert.equal(await viewer.page.locator("#reset-planes").isVisible(), false);
    const { x, y, width, height } = await viewer.page.locator("#picture").boundingBox();
    const place = await placeOf(viewer.page.locator("#planes .turn").first());
    const from = { x: place.x + place.width / 2, y: place.y + place.height / 2 };
    const middle = { x: x + width / 4, y: y + height / 4 };
    const depths = viewer.page.locator("#planes text.depth");
    assert.ok((await depths.count()) > 0);
    const { mouse } = viewer.page;
    await mouse.move(from.x, from.y);
    await mouse.down();
    await mouse.move(from.x, middle.y - 20, { steps: 4 });
    assert.equal(await depths.count(), 0, "no scale over planes that are being turned");
    await mouse.move(middle.x, middle.y - (from.x - middle.x), { steps: 4 });
    await mouse.up();
    await reaches(viewer, "slice.yaw_deg", 90, 0.5);
    await viewer.settled();
    const turned = await paneA(viewer);
    const [asExpected, asBefore] = [difference(turned, turnedLeft(straight)), difference(turned, straight)];
    assert.ok(asExpected < 0.5 * asBefore, `${asExpected} from a quarter of a turn, ${asBefore} from none`);
    assert.deepEqual((await names()).slice(0, 3), ["A (turned)", "B (turned)", "C (turned)"]);
    assert.equal(await depths.count(), 0, "no pane has the depth downwards");
    // The lines move the target along the turned axes: to the right in pane A is now along the depth.
    const depth = await viewer.field("camera.target_y_mm");
    await dragFrom(viewer, await pointOf(grip(viewer, "plane plane-B", 0), 0.2), 30, 0);
    const mmPerPixel = (await viewer.field("camera.field_mm")) / (height / 2);
    await reaches(viewer, "camera.target_y_mm", depth + 30 * mmPerPixel);
    await viewer.settled();
    await viewer.screenshot("planes-turned");
    await click(viewer, "#reset-planes");
    for (const angle of ["yaw", "pitch", "roll"]) await reaches(viewer, `slice.${angle}_deg`, 0, 0.001);
    await viewer.settled();
    assert.ok((await depths.count()) > 0);
    assert.equal(await viewer.page.locator("#reset-planes").isVisible(), false);
    const handleB = viewer.page.locator("#planes .turn").nth(1);
    await handleB.press("ArrowUp");
    await reaches(viewer, "slice.pitch_deg", 1, 0.01);
    await handleB.press("Shift+ArrowRight");
    await reaches(viewer, "slice.pitch_deg", -7, 0.01);

    // A finger turns the first handle by a quarter, as the mouse did.
    await click(viewer, "#reset-planes");
    await reaches(viewer, "slice.pitch_deg", 0, 0.001);
    const devtools = await viewer.page.context().newCDPSession(viewer.page);
    const touch = (type, ...touchPoints) => devtools.send("Input.dispatchTouchEvent", { type, touchPoints });
    await touch("touchStart", from);
    for (const deg of [15, 30, 45, 60, 75, 90]) {
      const [rad, radius] = [(deg * Math.PI) / 180, from.x - middle.x];
      await touch("touchMove", { x: middle.x + radius * Math.cos(rad), y: middle.y - radius * Math.sin(rad) });
    }
    await touch("touchEnd");
    await reaches(viewer, "slice.yaw_deg", 90, 0.5);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("the crop box has handles in all four panes, and opens again", async () => {
  await withStillPage("crop", async (viewer) => {
    await viewer.firstPicture();
    await press(viewer, "4");
    await press(viewer, "c");
    await viewer.settled();
    assert.equal(await viewer.page.locator('#planes [data-line="crop"]').count(), 12, "four sides in three panes");
    const { width } = await viewer.page.locator("#picture").boundingBox();
    const mmPerPixel = (await viewer.field("camera.field_mm")) / (width / 2);
    const left = (await viewer.field("camera.target_x_mm")) - (width / 4) * mmPerPixel;
    await dragFrom(viewer, await pointOf(grip(viewer, "crop", 0), 0.3), 60, 0);
    await reaches(viewer, "crop.left_mm", left + 60 * mmPerPixel, 3);
    const [before, number] = [await viewer.field("crop.right_mm"), await viewer.page.locator("#planes .face").count()];
    assert.ok(number >= 4, `${number} handles in the 3D pane`);
    const { x, y } = await placeOf(viewer.page.locator("#planes .face").nth(1));
    await dragFrom(viewer, { x: x + 6, y: y + 6 }, -40, 0);
    await until(
      "the right side",
      () => viewer.field("crop.right_mm"),
      (now) => now < before,
    );
    await viewer.settled();
    await viewer.screenshot("crop-box");
    await click(viewer, "#open-box");
    await reaches(viewer, "crop.left_mm", -1000);
    await reaches(viewer, "crop.right_mm", 1000);
    await press(viewer, "z");
    await reaches(viewer, "crop.left_mm", left + 60 * mmPerPixel, 3);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});
