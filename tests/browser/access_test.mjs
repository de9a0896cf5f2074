// Logging in, being in control, and pictures in other codecs, in a real browser against a real server.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { difference, until } from "./viewer_page.mjs";
import { withPage } from "./with_page.mjs";

const kMovingSource = "phantom:rate=20,speckle=off";
const kStillSource = "phantom:volumes=1,rate=20";
const kAlike = 6; // grey levels of 255

const control = (viewer) => viewer.page.locator("#control span").textContent();
const inert = (viewer) => viewer.page.locator("#controls").evaluate((form) => form.inert);

/** Runs the steps with a file of tokens and one token of the role in it. */
async function withToken(role, steps) {
  const folder = mkdtempSync(join(tmpdir(), "fanlight-"));
  try {
    const tokens = join(folder, "tokens.toml");
    const made = execFileSync(
      process.env.FANLIGHT_BIN,
      ["token", "add", "--tokens", tokens, "--name", "the test", "--role", role],
      { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] },
    );
    await steps(made.trim(), ["--tokens", tokens]);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

test("a token is asked for, a wrong one refused, and the right one kept for the tab", async () => {
  await withToken("viewer", async (token, options) => {
    await withPage(
      "login",
      kMovingSource,
      async (viewer, server) => {
        const form = viewer.page.locator("#login");
        await form.waitFor();
        await viewer.screenshot("login_form");
        await form.locator("input").fill(token.replace(/.$/, (last) => (last === "0" ? "1" : "0")));
        await form.locator("button").click();
        await until(
          "the refusal",
          () => form.locator("p").textContent(),
          (text) => text.includes("expected one that is known"),
        );
        await viewer.page.waitForTimeout(1200); // the wait that a wrong one costs
        await form.locator("input").fill(token);
        await form.locator("button").click();
        await viewer.firstPicture();
        assert.equal(await form.isVisible(), false);
        assert.match(await control(viewer), /^Watching/);
        assert.equal(await inert(viewer), true, "a viewer has controls");

        const volume = await viewer.number("volume-id");
        await server.end("SIGKILL");
        await until("the loss", () => viewer.connection(), (state) => state === "lost");
        await server.restart();
        await until("to be back", () => viewer.connection(), (state) => state === "open");
        await until("a volume", () => viewer.number("volume-id"), (id) => id > 0 && id !== volume);
      },
      options,
    );
  });
});

test("one display is in control at a time", async () => {
  await withPage("control", kStillSource, async (first, server) => {
    await first.firstPicture();
    const second = await server.another();
    try {
      await second.firstPicture();
      assert.equal(await first.page.locator("#control").isVisible(), false, "nobody is in control yet");
      await first.drag([0.5, 0.5], [0.6, 0.4]);
      await until("to be in control", () => control(first), (text) => text === "In control");
      await until("to be told", () => control(second), (text) => text === "loopback (display 1) is in control");
      assert.equal(await inert(second), true);
      assert.equal(await inert(first), false);
      await second.page.locator("#control button", { hasText: "Take over" }).click();
      await until("to be in control", () => control(second), (text) => text === "In control");
      await until("to be told", () => inert(first), (is) => is === true);
      await first.screenshot("not_in_control");
      await second.page.locator("#control button", { hasText: "Release" }).click();
      await until("freedom", () => inert(first), (is) => is === false);
      assert.deepEqual([...first.complaints, ...second.complaints], []);
    } finally {
      await second.page.close();
    }
  });
});

test("pictures travel as PNG and as H.264 too, and look alike", async () => {
  await withPage("codecs", kStillSource, async (viewer) => {
    await viewer.firstPicture();
    await viewer.drag([0.7, 0.4], [0.5, 0.5]);
    await viewer.settled();
    const jpeg = await viewer.grey();
    const codec = viewer.page.locator("#codec");
    for (const name of ["PNG, lossless", "H.264"]) {
      await codec.selectOption({ label: name });
      // A moved light makes pictures where the source stands still.
      await viewer.drag([0.5, 0.5], [0.7, 0.4]);
      await viewer.settled();
      assert.ok(difference(jpeg, await viewer.grey()) > kAlike, `${name}: the light moves`);
      await viewer.drag([0.7, 0.4], [0.5, 0.5]);
      await viewer.settled();
      assert.ok(difference(jpeg, await viewer.grey()) < kAlike, `${name}: ${difference(jpeg, await viewer.grey())}`);
      assert.equal(await codec.locator("option:checked").textContent(), name, "it fell back");
    }
    await viewer.screenshot("h264");
    assert.deepEqual(viewer.complaints, []);
  });
});

test("a viewer has a light and a camera of its own, and the others keep theirs", async () => {
  await withToken("viewer", async (token, options) => {
    await withPage(
      "own_view",
      kStillSource,
      async (viewer, server) => {
        const logIn = async ({ page }) => {
          await page.locator("#login input").fill(token);
          await page.locator("#login button").click();
        };
        await logIn(viewer);
        await viewer.firstPicture();
        const other = await server.another();
        try {
          await logIn(other);
          await other.firstPicture();
          const main = await other.grey();
          const box = viewer.page.locator("#own-view input");
          await box.check();
          assert.equal(await inert(viewer), false);
          await viewer.drag([0.3, 0.3], [0.75, 0.7]);
          await viewer.settled();
          const lit = await viewer.grey();
          assert.ok(difference(main, lit) > kAlike, "its own light moves its picture");
          await viewer.page.locator('#tools [value="orbit"]').check({ force: true });
          await viewer.drag([0.4, 0.5], [0.6, 0.5]);
          await viewer.settled();
          assert.ok(difference(lit, await viewer.grey()) > kAlike, "its own camera too");
          await viewer.screenshot("own_camera");
          const group = (name) => viewer.page.locator(`#controls [data-group="${name}"] .rows`);
          assert.equal(await group("detector").evaluate((rows) => rows.inert), true, "the threshold is everybody's");
          assert.equal(await group("light").evaluate((rows) => rows.inert), false);
          assert.ok(difference(main, await other.grey()) < 1, "the others see what they saw");
          await box.uncheck();
          await viewer.settled();
          assert.ok(difference(main, await viewer.grey()) < 1, "and so does this one again");
          assert.equal(await inert(viewer), true);
          assert.deepEqual([...viewer.complaints, ...other.complaints], []);
        } finally {
          await other.page.close();
        }
      },
      options,
    );
  });
});
