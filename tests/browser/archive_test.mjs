// SPDX-License-Identifier: Apache-2.0
// Tests in Chromium how a still goes to the queue for the archive. Variables: see viewer_test.mjs.
import assert from "node:assert/strict";
import { mkdtempSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import AxeBuilder from "@axe-core/playwright";
import { until } from "./viewer_page.mjs";
import { kStillSource, withPage, withStillPage } from "./with_page.mjs";

const objectsIn = (folder) => readdirSync(folder).filter((name) => name.endsWith(".dcm"));

test("a still goes to the queue under the patient that was typed in, or that of an order", async () => {
  const folder = mkdtempSync(join(tmpdir(), "archive_"));
  const queue = join(folder, "queue");
  const audit = join(folder, "audit.jsonl");
  const steps = async (viewer, server) => {
    const { page } = viewer;
    const dialog = page.locator("#archive-form");
    const box = (name) => dialog.getByLabel(name, { exact: true });
    const button = (name) => dialog.getByRole("button", { name, exact: true });
    const waiting = (objects) =>
      until(
        `${objects} objects in the queue`,
        () => objectsIn(queue).length,
        (found) => found === objects,
      );
    await viewer.firstPicture();
    await viewer.settled();
    await page.locator("#archive").click();
    await dialog.waitFor({ state: "visible" });
    const report = await new AxeBuilder({ page }).withTags(["wcag2a", "wcag2aa"]).include("#archive-form").analyze();
    assert.deepEqual(
      report.violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html)]),
      [],
    );

    await button("Send").click();
    assert.equal(await box("Patient ID").evaluate((input) => input.validationMessage), "Enter a patient ID or a name.");
    await box("Patient ID").fill("P-17");
    await box("Family name").fill("Doe");
    await box("Given name").fill("Jane");
    await box("Date of birth").fill("1990-02-03");
    await box("Sex").selectOption("Female");
    await viewer.screenshot("archive-form");
    await page.keyboard.press("Enter"); // in the form, which sends it
    await dialog.waitFor({ state: "hidden" });
    assert.match(await page.locator("#archived").textContent(), /waits in the queue/);
    await waiting(1);

    // The patient stays for the next still, until another one is wanted.
    await page.locator("#archive").click();
    assert.equal(await box("Family name").inputValue(), "Doe");
    await until(
      "what waits",
      () => dialog.textContent(),
      (text) => /1 earlier item waits/.test(text),
    );
    await button("Other patient").click();
    assert.equal(await box("Patient ID").inputValue(), "");
    const order = join(folder, "order.json");
    writeFileSync(order, JSON.stringify({ patient_id: "P-18", patient_name: "Roe^Mary", study_uid: "1.2.3.4" }));
    await dialog.locator("[type=file]").setInputFiles(order);
    await until(
      "the order",
      () => box("Given name").inputValue(),
      (name) => name === "Mary",
    );
    assert.equal(await box("Patient ID").getAttribute("readonly"), "", "the order's study is this patient's");
    await button("Send").click();
    await dialog.waitFor({ state: "hidden" });
    await waiting(2);
    const second = objectsIn(queue).sort()[1];
    assert.ok(readFileSync(join(queue, second), "latin1").includes("1.2.3.4"), "the order's study");
    assert.ok(statSync(join(queue, second)).size > 512 * 512 * 3, "the whole picture");

    // The volume, once it is frozen.
    await page.locator("#archive").click();
    await dialog.waitFor({ state: "visible" });
    assert.equal(await dialog.locator("option[value=volume]").evaluate((option) => option.disabled), true);
    assert.match(await dialog.locator("option[value=volume]").textContent(), /freeze the picture first/);
    await button("Cancel").click();
    await page.keyboard.press("Space");
    await until(
      "the frozen picture",
      () => page.locator("#not-live").textContent(),
      (mark) => /^Frozen/.test(mark),
    );
    const devtools = await page.context().newCDPSession(page);
    const tap = async (locator) => {
      const { x, y, width, height } = await locator.boundingBox();
      const touchPoints = [{ x: x + width / 2, y: y + height / 2 }];
      await devtools.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints });
      await devtools.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
    };
    await tap(page.locator("#archive"));
    await dialog.waitFor({ state: "visible" });
    await box("What to send").selectOption("Frozen volume");
    assert.match(await dialog.textContent(), /echoes of the frozen volume/);
    await viewer.screenshot("archive-volume");
    await tap(button("Send"));
    await dialog.waitFor({ state: "hidden" });
    assert.match(await page.locator("#archived").textContent(), /The volume waits in the queue/);
    await waiting(3);
    const volume = readFileSync(join(queue, objectsIn(queue).sort()[2]), "latin1");
    assert.ok(volume.includes("1.2.840.10008.5.1.4.1.1.6.2"), "an Enhanced US Volume");
    assert.ok(volume.includes("1.2.3.4") && volume.includes("P-18"), "of the order");

    // A clip of what is shown.
    await page.locator("#archive").click();
    await box("What to send").selectOption("Clip of 5 s");
    await button("Send").click();
    await dialog.waitFor({ state: "hidden" }); // the picture can be seen
    await waiting(4);
    await until(
      "the end of the clip",
      () => page.locator("#archived").textContent(),
      (text) => /The clip of 5\.0 s waits in the queue/.test(text),
    );
    assert.equal(await page.locator("#archive").textContent(), "Send");
    const clip = readFileSync(join(queue, objectsIn(queue).sort()[3]), "latin1");
    assert.ok(clip.includes("1.2.840.10008.5.1.4.1.1.3.1"), "an Ultrasound Multi-frame Image");
    const pictures = clip.split("\xff\xd8\xff").length - 1;
    assert.equal(pictures, 50, "ten a second, for five seconds");

    // A refusal is shown in the form, and the form stays.
    await page.locator("#archive").click();
    await button("Other patient").click();
    await box("Patient ID").fill("back\\slash");
    await button("Send").click();
    await until(
      "a refusal",
      () => dialog.locator("[role=alert]").textContent(),
      (text) => /was not sent: .*patient_id/.test(text),
    );
    await button("Cancel").click();
    await page.keyboard.press("s"); // keys of the page work again
    const log = readFileSync(audit, "utf8");
    assert.equal(log.match(/"what":"archive"/g).length, 5);
    for (const object of ["still", "clip", "volume"]) assert.match(log, new RegExp(`"object":"${object}"`));
    assert.doesNotMatch(log, /P-17|Doe|Roe|1990/, "no patient in the log");
    assert.doesNotMatch(objectsIn(queue).join(), /Doe|P-1/);
    const metrics = await (await fetch(new URL("metrics", server.url))).text();
    assert.match(metrics, /^fanlight_archive_stills_total 3$/m);
    // The browser reports the refused request.
    assert.equal(viewer.consoleProblems.filter((text) => !/400/.test(text)).length, 0, viewer.consoleProblems.join());
  };
  try {
    await withPage("archive", kStillSource, steps, ["--archive-queue", queue, "--audit-log", audit]);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test("a server without a queue offers nothing to send", async () => {
  await withStillPage("no-archive", async (viewer) => {
    assert.equal(await viewer.page.locator("#share").isVisible(), true);
    assert.equal(await viewer.page.locator("#archive").isVisible(), false);
    assert.deepEqual(viewer.consoleProblems, []);
  });
});
