// SPDX-License-Identifier: Apache-2.0
// Provides a server and a page for a test. All tests of a file share one browser, and its cache.
import { after, before } from "node:test";
import { ServerProcess } from "./server_process.mjs";
import { kViewport, launchChromium, until, ViewerPage } from "./viewer_page.mjs";

/** One volume, which stays. */
export const kStillSource = process.env.FANLIGHT_STILL_SOURCE ?? "phantom:scene=relief,probe=r1,volumes=1,rate=20";

let browser;
let context;
let still; // the server of withStillPage()
before(async () => {
  browser = await launchChromium();
  context = await browser.newContext({ viewport: kViewport });
});
after(async () => {
  await still?.server.end();
  await browser?.close();
});

/**
 * Starts a server with the source, opens its page and runs `steps(viewer, server)`. Takes a screenshot and stops the
 * page and the server afterwards, also when a step fails.
 * `name`: of the screenshot. `options`: further command line options of the server.
 */
export async function withPage(name, source, steps, options = []) {
  let server = await ServerProcess.start(source, 0, options);
  let viewer;
  try {
    viewer = await ViewerPage.open(context, server.url);
    const restart = async () => {
      server = await ServerProcess.start(source, server.port, options);
    };
    // In a window of its own: a browser slows pages in the background.
    const openPage = () => ViewerPage.open(browser, server.url);
    await steps(viewer, {
      end: (signal) => server.end(signal),
      send: (signal) => server.send(signal),
      restart,
      openPage,
      url: server.url,
    });
  } catch (error) {
    error.message += `\nconsole problems of the page: ${JSON.stringify(viewer?.consoleProblems)}\nthe server printed:\n${server.output}`;
    throw error;
  } finally {
    await viewer?.screenshot(name);
    await viewer?.page.close();
    await server.end();
  }
}

async function readScene(server) {
  return (await (await fetch(new URL("api/scene", server.url))).json()).scene;
}

/** Waits until the page of the test before has left, which may be in control. */
async function resetScene(server, scene) {
  const headers = { "Content-Type": "application/json" };
  await fetch(new URL("api/measurements", server.url), { method: "POST", headers, body: '{"remove_all": true}' });
  const change = { method: "PATCH", headers, body: JSON.stringify(scene) };
  return until(
    "status 200 for the scene of the start",
    async () => (await fetch(new URL("api/scene", server.url), change)).status,
    (status) => status === 200,
  );
}

/**
 * Opens a page that shows one volume, which does not change, and runs `steps(viewer, server)`. The tests of a file share
 * its server, which takes two seconds to start: the scene is as at its start, and the page keeps nothing from before.
 * `name`: of the screenshot.
 */
export async function withStillPage(name, steps) {
  still ??= { server: await ServerProcess.start(kStillSource) };
  const { server, scene } = still;
  let viewer;
  try {
    if (scene) await resetScene(server, scene);
    viewer = await ViewerPage.open(context, server.url);
    await viewer.firstPicture();
    await viewer.settled();
    // Only now: values that follow from the volume are in it.
    still.scene ??= await readScene(server);
    await steps(viewer, { openPage: () => ViewerPage.open(browser, server.url), url: server.url });
  } catch (error) {
    error.message += `\nconsole problems of the page: ${JSON.stringify(viewer?.consoleProblems)}\nthe server printed:\n${server.output}`;
    throw error;
  } finally {
    try {
      await viewer?.screenshot(name);
      await viewer?.page.evaluate(() => [localStorage, sessionStorage].forEach((storage) => storage.clear()));
    } finally {
      await viewer?.page.close(); // else it stays in control
    }
  }
}
