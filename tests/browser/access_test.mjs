// SPDX-License-Identifier: Apache-2.0
// Tests login, control, private views and codecs in Chromium against the real server.
//   FANLIGHT_BIN           the fanlight binary (required)
//   FANLIGHT_ARTIFACTS     a folder for screenshots
//   CHROMIUM               the browser, if not /usr/bin/chromium
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { difference, until } from "./viewer_page.mjs";
import { kStillSource, withPage, withStillPage } from "./with_page.mjs";

const kMovingSource = "phantom:scene=relief,probe=r1,frames=18,rate=20,speckle=off";
const kMaxSameDifference = 6; // mean grey levels of 255; pictures of the same scene differ by less

const controlText = (viewer) => viewer.page.locator("#control span").textContent();
const controlsInert = (viewer) => viewer.page.locator("#controls").evaluate((form) => form.inert);

/** Creates a token file with one token of the role; calls `steps(token, serverOptions)`; removes the file. */
async function withToken(role, steps) {
  const folder = mkdtempSync(join(tmpdir(), "fanlight-"));
  try {
    const tokens = join(folder, "tokens.toml");
    const printed = execFileSync(
      process.env.FANLIGHT_BIN,
      ["token", "add", "--tokens", tokens, "--name", "the test", "--role", role],
      { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] },
    );
    await steps(printed.trim(), ["--tokens", tokens]);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

test("the page requests a token, shows the refusal of a wrong one, and keeps the valid one for the tab", async () => {
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
          "the text of the refusal",
          () => form.locator("p").textContent(),
          (text) => text.includes("expected one that is known"),
        );
        await viewer.page.waitForTimeout(1200); // longer than the login back-off after one wrong token
        // On a busy machine the end of the refused connection may arrive late and show the form again.
        await until(
          "a picture after the login",
          async () => {
            if (await form.isVisible()) {
              await form.locator("input").fill(token);
              await form.locator("button").click();
            }
            return { picture: await viewer.number("picture-id"), connection: await viewer.connection() };
          },
          ({ picture }) => picture >= 1,
        );
        assert.equal(await form.isVisible(), false);
        assert.match(await controlText(viewer), /^Watching/);
        assert.equal(await controlsInert(viewer), true, "the controls are active for the role viewer");

        const volume = await viewer.number("volume-id");
        await server.end("SIGKILL");
        await until(
          "the connection to be lost",
          () => viewer.connection(),
          (state) => state === "lost",
        );
        await server.restart();
        await until(
          "the connection to be open again",
          () => viewer.connection(),
          (state) => state === "open",
        );
        await until(
          "a new volume id",
          () => viewer.number("volume-id"),
          (id) => id > 0 && id !== volume,
        );
      },
      options,
    );
  });
});

test("one display at a time holds control", async () => {
  await withStillPage("control", async (first, server) => {
    await first.firstPicture();
    const second = await server.openPage();
    try {
      await second.firstPicture();
      assert.equal(
        await first.page.locator("#control").isVisible(),
        false,
        "the control line is shown before a session holds control",
      );
      await first.drag([0.5, 0.5], [0.6, 0.4]);
      await until(
        "the first display to show that it is in control",
        () => controlText(first),
        (text) => text === "You control",
      );
      await until(
        "the second display to name the display in control",
        () => controlText(second),
        (text) => text === "loopback (display 1) is in control",
      );
      assert.equal(await controlsInert(second), true);
      assert.equal(await controlsInert(first), false);
      await second.page.locator("#control button", { hasText: "Take over" }).click();
      await until(
        "the second display to show that it is in control",
        () => controlText(second),
        (text) => text === "You control",
      );
      await until(
        "the controls of the first display to be inert",
        () => controlsInert(first),
        (inert) => inert === true,
      );
      await first.screenshot("not_in_control");
      await second.page.locator("#control button", { hasText: "Release" }).click();
      await until(
        "the controls of the first display to be active again",
        () => controlsInert(first),
        (inert) => inert === false,
      );
      assert.deepEqual([...first.consoleProblems, ...second.consoleProblems], []);
    } finally {
      await second.page.close();
    }
  });
});

test("PNG and H.264 show the same picture as JPEG", async () => {
  await withStillPage("codecs", async (viewer) => {
    await viewer.firstPicture();
    await viewer.drag([0.7, 0.4], [0.5, 0.5]);
    await viewer.settled();
    const jpeg = await viewer.greyLevels();
    const codec = viewer.page.locator("#codec");
    for (const name of ["PNG, lossless", "H.264"]) {
      await codec.selectOption({ label: name });
      // The source shows one volume only: moving the light causes new pictures.
      await viewer.drag([0.5, 0.5], [0.7, 0.4]);
      await viewer.changedFrom(jpeg, kMaxSameDifference, `${name}: the light`);
      await viewer.drag([0.7, 0.4], [0.5, 0.5]);
      await viewer.settled();
      assert.ok(
        difference(jpeg, await viewer.greyLevels()) < kMaxSameDifference,
        `${name}: ${difference(jpeg, await viewer.greyLevels())}`,
      );
      assert.equal(await codec.locator("option:checked").textContent(), name, "the page selected another codec");
    }
    await viewer.screenshot("h264");
    assert.deepEqual(viewer.consoleProblems, []);
  });
});

test("a private view has its own light and camera and leaves the shared view unchanged", async () => {
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
        const other = await server.openPage();
        try {
          await logIn(other);
          await other.firstPicture();
          const shared = await other.greyLevels();
          const checkbox = viewer.page.locator("#own-view input");
          await checkbox.check();
          assert.equal(await controlsInert(viewer), false);
          await viewer.drag([0.3, 0.3], [0.75, 0.7]);
          await viewer.changedFrom(shared, kMaxSameDifference, "the private light");
          await viewer.settled();
          const lit = await viewer.greyLevels();
          await viewer.page.locator('#tools [value="orbit"]').check({ force: true });
          await viewer.drag([0.4, 0.5], [0.6, 0.5]);
          await viewer.changedFrom(lit, kMaxSameDifference, "the private camera");
          await viewer.screenshot("own_camera");
          const group = (name) => viewer.page.locator(`#controls [data-group="${name}"] .rows`);
          assert.equal(await group("detector").evaluate((rows) => rows.inert), true, "the shared threshold can be set");
          assert.equal(await group("light").evaluate((rows) => rows.inert), false);
          assert.ok(difference(shared, await other.greyLevels()) < 1, "the private view changed the shared picture");
          await checkbox.uncheck();
          await viewer.settled();
          assert.ok(
            difference(shared, await viewer.greyLevels()) < 1,
            "the picture is not the shared one after leaving the private view",
          );
          assert.equal(await controlsInert(viewer), true);
          assert.deepEqual([...viewer.consoleProblems, ...other.consoleProblems], []);
        } finally {
          await other.page.close();
        }
      },
      options,
    );
  });
});
