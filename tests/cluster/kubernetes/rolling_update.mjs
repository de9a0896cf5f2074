// SPDX-License-Identifier: Apache-2.0
// What tests/cluster/kubernetes/run measures and checks: rolling_update.mjs FANLIGHT DEPLOY [SOURCE], with BROWSER, the
// folder of the browser tests' stage. SOURCE: another than that of the overlay. It has a network of its own.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { connect } from "node:tls";
import { setTimeout as pause } from "node:timers/promises";
import { build } from "./kustomize.mjs";
import { Pod, writeVolume } from "./pod.mjs";
import { podOf, workloadsOf } from "./rules.mjs";

const [fanlight, deploy, source] = process.argv.slice(2);
const { launchChromium, until } = await import(pathToFileURL(join(process.env.BROWSER, "viewer_page.mjs")));
const kAddress = "https://127.0.0.1:8443/";
const work = mkdtempSync(join(tmpdir(), "fanlight-pod-"));
const tell = (line) => console.log(`kubernetes: ${line}`);
const seconds = (began) => ((performance.now() - began) / 1000).toFixed(1);

function certificate(name) {
  const [key, file] = [join(work, `${name}.key`), join(work, `${name}.crt`)];
  const made = "-x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -noenc -days 2 -subj /CN=fanlight".split(" ");
  execFileSync("openssl", ["req", ...made, "-keyout", key, "-out", file], { stdio: "pipe" });
  return { "tls.crt": readFileSync(file, "utf8"), "tls.key": readFileSync(key, "utf8") };
}

function addToken(file, name) {
  const command = ["token", "add", "--tokens", file, "--name", name, "--role", "viewer"];
  return execFileSync(fanlight, command, { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] }).trim();
}

/** The fingerprint of the server's certificate. */
function fingerprint() {
  return new Promise((resolve, reject) => {
    const socket = connect({ host: "127.0.0.1", port: 8443, rejectUnauthorized: false }, () => {
      resolve(socket.getPeerCertificate().fingerprint256);
      socket.destroy();
    });
    socket.on("error", reject);
  });
}

async function openDisplay(browser, token) {
  const context = await browser.newContext({ ignoreHTTPSErrors: true, viewport: { width: 1280, height: 800 } });
  const page = await context.newPage();
  await page.goto(kAddress);
  await page.locator("#login input").fill(token);
  await page.locator("#login button").click();
  return page;
}

const pictureState = (page) => page.locator("html").getAttribute("data-picture");
const isLive = (page) =>
  until(
    "a display to be live",
    () => pictureState(page),
    (state) => state === "live",
  );

const resources = build(join(deploy, "kubernetes/overlays/simulated"));
if (source) resources.find((each) => each.data?.FANLIGHT_SOURCE).data.FANLIGHT_SOURCE = source;
const [set] = workloadsOf(resources);
const grace_s = podOf(set).terminationGracePeriodSeconds;
const tokens = join(work, "tokens.toml");
const [staying, leaving] = [addToken(tokens, "stays"), addToken(tokens, "leaves")];
const both = readFileSync(tokens, "utf8");
let count = 0;
const startPod = (secrets) => new Pod(fanlight, set, resources, join(work, `pod-${(count += 1)}`), secrets);

let pod;
let browser;
try {
  const secrets = { "fanlight-tls": certificate("first"), "fanlight-tokens": { "tokens.toml": both } };
  let began = performance.now();
  pod = startPod(secrets);
  await pod.until("startupProbe", 120);
  await pod.until("readinessProbe", 60);
  tell(`ready after ${seconds(began)} s with empty caches`);
  assert.match(pod.status, /Uid:\t10001\t10001\t10001\t10001\n/);
  assert.match(pod.status, /CapBnd:\t0+\n/);
  assert.match(pod.status, /NoNewPrivs:\t1\n/);
  assert.match(pod.status, /NSpid:\t\d+\t1\n/);

  browser = await launchChromium();
  const displays = [await openDisplay(browser, staying), await openDisplay(browser, leaving)];
  for (const page of displays) await isLive(page);
  await pause(60_000);
  tell(`${pod.peakMebibytes.toFixed(0)} MiB of memory at most, two displays, after a minute`);

  // Another certificate and other tokens, as a kubelet writes them.
  const before = await fingerprint();
  began = performance.now();
  writeVolume(pod.volume("tls"), certificate("second"), podOf(set).securityContext.fsGroup);
  await until(
    "the second certificate",
    () => fingerprint(),
    (now) => now !== before,
  );
  tell(`the new certificate after ${seconds(began)} s`);
  const one = both.slice(0, both.lastIndexOf("[["));
  assert.match(one, /stays/);
  assert.doesNotMatch(one, /leaves/);
  began = performance.now();
  writeVolume(pod.volume("tokens"), { "tokens.toml": one }, podOf(set).securityContext.fsGroup);
  await displays[1].locator("#login").waitFor();
  tell(`a display whose token was revoked is asked for another after ${seconds(began)} s`);
  assert.equal(await pictureState(displays[0]), "live", "the other display stays");

  // The update: the old pod ends, then the new one starts.
  secrets["fanlight-tokens"] = { "tokens.toml": one };
  for (const round of [1, 2, 3]) {
    began = performance.now();
    assert.equal(await pod.end(grace_s), 0, `the pod ends by itself within ${grace_s} s\n${pod.output}`);
    const ended = seconds(began);
    began = performance.now();
    pod = startPod(secrets);
    await pod.until("readinessProbe", 120);
    const ready = seconds(began);
    await isLive(displays[0]);
    assert.equal(await displays[0].locator("#login").isVisible(), false, "the display is still logged in");
    tell(
      `update ${round}: ended in ${ended} s, ready ${ready} s after the start, the display live after ${seconds(began)} s`,
    );
  }
  assert.equal(await pod.probe("livenessProbe"), 200);
} catch (error) {
  error.message += `\nthe pod printed:\n${pod?.output}`;
  throw error;
} finally {
  await browser?.close();
  await pod?.end(grace_s);
  rmSync(work, { recursive: true });
}
