// SPDX-License-Identifier: Apache-2.0
// Provides a server and a page for a test. All tests of a file share one browser, and its cache.
import { after, before } from "node:test";
import { ServerProcess } from "./server_process.mjs";
import { kViewport, launchChromium, ViewerPage } from "./viewer_page.mjs";

let browser;
let context;
before(async () => {
  browser = await launchChromium();
  context = await browser.newContext({ viewport: kViewport });
});
after(() => browser?.close());

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
