// A server and a page for a test. One browser serves all tests of a file.
import { after, before } from "node:test";
import { Served } from "./served.mjs";
import { launchChromium, ViewerPage } from "./viewer_page.mjs";

let browser;
before(async () => {
  browser = await launchChromium();
});
after(() => browser?.close());

/** Runs the steps with a server and a page; whatever happens, takes a screenshot and ends both. */
export async function withPage(name, source, steps, more = []) {
  let server = await Served.start(source, 0, more);
  let viewer;
  try {
    viewer = await ViewerPage.open(browser, server.url);
    const restart = async () => {
      server = await Served.start(source, server.port, more);
    };
    const another = () => ViewerPage.open(browser, server.url);
    await steps(viewer, { end: (signal) => server.end(signal), restart, another, url: server.url });
  } catch (error) {
    error.message += `\nthe page complained: ${JSON.stringify(viewer?.complaints)}\nthe server printed:\n${server.output}`;
    throw error;
  } finally {
    await viewer?.screenshot(name);
    await viewer?.page.close();
    await server.end();
  }
}
