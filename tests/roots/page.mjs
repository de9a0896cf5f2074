// SPDX-License-Identifier: Apache-2.0
// Takes a picture of a server's page when it is live.
//   page.mjs STAGE URL PICTURE    STAGE: build/release/tests/browser/stage, which has Playwright
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

const [stage, url, picture] = process.argv.slice(2);
const { chromium } = createRequire(join(resolve(stage), "package.json"))("playwright-core");
const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--disable-background-networking"],
});
try {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  await page.goto(url);
  await page.waitForFunction(() => /LIVE|SIMULATED/.test(document.body.innerText), undefined, { timeout: 60_000 });
  await page.screenshot({ path: picture });
} finally {
  await browser.close();
}
