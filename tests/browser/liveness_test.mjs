// SPDX-License-Identifier: Apache-2.0
// Tests in Chromium, against the real server, that an old picture never looks live, and that the page says where its
// pictures go.
//   FANLIGHT_BIN           the fanlight binary (required)
//   FANLIGHT_ARTIFACTS     a folder for screenshots
//   CHROMIUM               the browser, if not /usr/bin/chromium
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { createSocket } from "node:dgram";
import { once } from "node:events";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { until } from "./viewer_page.mjs";
import { withPage } from "./with_page.mjs";

const kMovingSource = "phantom:scene=relief,probe=r1,frames=18,rate=20,speckle=off";

function waitForWord(viewer, expected) {
  return until(
    `the header to say ${expected}`,
    () => viewer.page.locator("#connection [role=status]").textContent(),
    (word) => word === expected,
  );
}

function waitForNotice(viewer, pattern) {
  return until(
    `the notice to match ${pattern}`,
    () => viewer.page.locator("#notice").textContent(),
    (text) => pattern.test(text),
  );
}

test("a server that is stopped with its socket open is seen, and a change says that it waits", async () => {
  await withPage("server-stopped", kMovingSource, async (viewer, server) => {
    await viewer.firstPicture();
    await waitForWord(viewer, "Simulated");
    assert.equal(await viewer.page.locator("#not-live").isVisible(), false);
    await viewer.screenshot("live");
    server.send("SIGSTOP");
    await viewer.drag([0.3, 0.3], [0.7, 0.6]);
    await waitForNotice(viewer, /The server does not answer/);
    assert.match(await viewer.page.locator("#not-live").textContent(), /^Lost, \d+ s old$/);
    assert.match(await viewer.page.locator("#frame").getAttribute("class"), /stale/);
    assert.equal(
      await viewer.page.locator("#rendering").isVisible(),
      true,
      "nothing says that the light is on its way",
    );
    await viewer.screenshot("stopped");
    server.send("SIGCONT");
    await waitForWord(viewer, "Simulated");
    await until(
      "the marks to go",
      () => viewer.page.locator("#not-live, #rendering, #notice").evaluateAll((marks) => marks.every((m) => m.hidden)),
      (gone) => gone,
    );
  });
});

test("the last volume of a source that has ended is marked, also when it is lit again", async () => {
  await withPage("source-ended", "phantom:scene=relief,probe=r1,volumes=1,rate=20", async (viewer, server) => {
    await viewer.firstPicture();
    await waitForWord(viewer, "Lost");
    await waitForNotice(viewer, /The recording has ended.*The last volume is still shown\./);
    const pass2 = await viewer.number("pass2-runs");
    await viewer.drag([0.3, 0.3], [0.7, 0.6]);
    await until(
      "the moved light",
      () => viewer.number("pass2-runs"),
      (runs) => runs > pass2,
    );
    await viewer.settled();
    assert.equal(await viewer.page.locator("#connection [role=status]").textContent(), "Lost");
    assert.match(await viewer.page.locator("#not-live").textContent(), /^Lost, \d+ s old$/);
    const health = await (await fetch(new URL("healthz", server.url))).text();
    assert.match(health, /^ok; source ended; picture not live, [\d.]+ s old; The recording has ended\.$/m);
    const metrics = await (await fetch(new URL("metrics", server.url))).text();
    assert.match(metrics, /^fanlight_picture_live 0$/m);
    assert.match(metrics, /^fanlight_picture_age_seconds \d/m);
  });
});

test("a replay says so on its picture, and is paused, stepped and moved by its bar", async () => {
  const folder = mkdtempSync(join(tmpdir(), "fanlight-"));
  const recording = join(folder, "sweeps.igs.mha");
  execFileSync(process.env.FANLIGHT_BIN, [
    ..."record phantom:scene=relief,probe=r1,columns=64,rows=64,volumes=8,rate=100 --fast --out".split(" "),
    recording,
  ]);
  await withPage(
    "replay",
    recording,
    async (viewer, server) => {
      await viewer.firstPicture();
      await waitForWord(viewer, "Replay");
      assert.equal(await viewer.page.locator("#not-live").textContent(), "Replay");
      const bar = viewer.page.locator("#replay");
      const told = () => bar.locator("[data-replay=text]").textContent();
      await bar.getByRole("button", { name: "Pause" }).click();
      await bar.getByRole("button", { name: "Play", exact: true }).waitFor();
      await bar.getByRole("slider").fill("0");
      await until("the first sweep", told, (text) => text.includes("sweep 1 of "));
      await bar.getByRole("button", { name: "Step forward" }).click();
      await until("the second sweep", told, (text) => text.includes("sweep 2 of "));
      await bar.getByRole("button", { name: "Step back" }).click();
      await until("the first sweep again", told, (text) => text.includes("sweep 1 of "));
      await bar.getByLabel("Speed").selectOption("2");
      await bar.getByLabel("After the last frame").selectOption("Once");
      await bar.getByRole("button", { name: "Play", exact: true }).click();
      await until("the end", told, (text) => text.endsWith("ended"));
      const state = await (await fetch(new URL("api/replay", server.url))).json();
      assert.deepEqual([state.state, state.speed, state.ending], ["ended", 2, "once"]);
      await waitForNotice(viewer, /The recording has ended.*The last volume is still shown\./);
      await waitForWord(viewer, "Replay ended");
      assert.equal(await viewer.page.locator("#not-live").textContent(), "Replay ended");
      assert.equal(await viewer.page.locator("#frame.stale, .frame.stale").count(), 0);
    },
    ["--ending", "loop"],
  );
  rmSync(folder, { recursive: true });
});

test("the page says while its pictures are sent beyond the room", async () => {
  const receiver = createSocket("udp4");
  receiver.bind(0, "127.0.0.1");
  await once(receiver, "listening");
  let packets = 0;
  receiver.on("message", () => (packets += 1));
  try {
    const relay = async (viewer, wish) => {
      const answer = await viewer.page.evaluate(
        async (body) =>
          (await fetch("/api/rtp", { method: "POST", body, headers: { "Content-Type": "application/json" } })).status,
        JSON.stringify({ wish }),
      );
      assert.equal(answer, 200);
    };
    await withPage(
      "sent-outside",
      "phantom:scene=relief,probe=r1,rate=60,speckle=off",
      async (viewer, server) => {
        const badge = viewer.page.locator("#relay");
        await viewer.firstPicture();
        assert.equal(await badge.isVisible(), false);
        await relay(viewer, "start");
        await badge.waitFor();
        await until(
          "packets at the receiver",
          () => packets,
          (count) => count > 0,
        );
        const later = await server.openPage();
        await later.page.locator("#relay").waitFor();
        await later.page.close();
        await viewer.screenshot("sent-outside-badge");
        await relay(viewer, "stop");
        await badge.waitFor({ state: "hidden" });
        assert.deepEqual(viewer.consoleProblems, []);
      },
      ["--rtp-to", `127.0.0.1:${receiver.address().port}`],
    );
  } finally {
    receiver.close();
  }
});
