// SPDX-License-Identifier: Apache-2.0
// The REST API against its description: calls every operation with every role, and compares what comes with what
// /api/openapi.json says. Also runs the examples of deploy/API.md.
//   FANLIGHT_BIN     the fanlight binary (required)
//   FANLIGHT_ROOT    the root of the source tree (required)
//   FANLIGHT_UPDATE  1: writes deploy/openapi.json
import { Validator } from "@seriousme/openapi-schema-validator";
import Ajv2020 from "ajv/dist/2020.js";
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { ServerProcess } from "./server_process.mjs";

const kRoles = ["viewer", "operator", "admin"];
const kSource = "phantom:scene=relief,probe=r1,frames=18,rate=60,speckle=off";
const kMostMs = 20_000;
const kCopy = join(process.env.FANLIGHT_ROOT, "deploy/openapi.json");
const kGuide = join(process.env.FANLIGHT_ROOT, "deploy/API.md");

const folder = mkdtempSync(join(tmpdir(), "fanlight-"));
const tokens = {};
let server;
let description;

before(async () => {
  const file = join(folder, "tokens.toml");
  for (const role of kRoles) {
    tokens[role] = execFileSync(
      process.env.FANLIGHT_BIN,
      ["token", "add", "--tokens", file, "--name", `the ${role}`, "--role", role],
      { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] },
    ).trim();
  }
  server = await ServerProcess.start(kSource, 0, [
    "--tokens",
    file,
    "--recordings",
    folder,
    "--presets",
    join(folder, "presets.json"),
  ]);
  description = await (await call("GET", "/api/openapi.json", { role: "viewer" })).json();
  while ((await call("GET", "/api/picture.png", { role: "viewer" })).status === 503) await sleep(50);
});

after(async () => {
  await server?.end();
  rmSync(folder, { recursive: true });
});

/** `body`: an object, or a text that is sent as it is. */
function call(method, path, { role, body, headers = {}, ...options } = {}) {
  const all = new Headers(headers);
  if (role) all.set("Authorization", `Bearer ${tokens[role]}`);
  if (body !== undefined) all.set("Content-Type", "application/json");
  const text = body === undefined || typeof body === "string" ? body : JSON.stringify(body);
  const signal = AbortSignal.timeout(kMostMs);
  return fetch(new URL(path, server.url), { method, headers: all, body: text, signal, ...options });
}

function operations() {
  return Object.entries(description.paths).flatMap(([path, methods]) =>
    Object.entries(methods).map(([method, operation]) => ({ path, method: method.toUpperCase(), ...operation })),
  );
}

const exampleOf = (operation) => operation.requestBody?.content["application/json"].example;

/** The response that the description has for a status, with its references followed. */
function describedResponse(operation, status) {
  const response = operation.responses[status];
  assert.ok(response, `${operation.operationId} answers ${status}, expected ${Object.keys(operation.responses)}`);
  return response.$ref ? description.components.responses[response.$ref.split("/").at(-1)] : response;
}

/** The schemas with no property beyond those that they name: what the server adds must be described. */
function closed(schema) {
  if (Array.isArray(schema)) return schema.map(closed);
  if (schema === null || typeof schema !== "object") return schema;
  const copy = Object.fromEntries(Object.entries(schema).map(([key, value]) => [key, closed(value)]));
  if (copy.type === "object" && copy.properties && !("openapi" in copy.properties)) copy.additionalProperties ??= false;
  return copy;
}

function bodyChecker() {
  const ajv = new Ajv2020({ strict: false });
  ajv.addSchema({ $id: "https://fanlight.invalid/api", components: closed(description.components) });
  return (reference, body) => {
    const check = ajv.getSchema(`https://fanlight.invalid/api${reference}`);
    assert.ok(check(body), `${reference}: ${JSON.stringify(check.errors)}\n${JSON.stringify(body).slice(0, 400)}`);
  };
}

/** Compares a response with the description; returns its body. */
async function checkResponse(operation, response, check) {
  const { content } = describedResponse(operation, response.status);
  const type = response.headers.get("Content-Type").split(";")[0];
  assert.ok(content[type], `${operation.operationId} answers with ${type}, expected ${Object.keys(content)}`);
  if (!type.includes("json")) return response.arrayBuffer();
  const body = await response.json();
  check(content[type].schema.$ref, body);
  return body;
}

const isStream = (operation) => operation.path === "/api/stream.mjpeg";

test("the description is valid OpenAPI 3.1, and the copy in deploy/ is up to date", async () => {
  const result = await new Validator().validate(structuredClone(description));
  assert.ok(result.valid, JSON.stringify(result.errors));
  const copy = { ...description, info: { ...description.info, version: "0" } };
  const text = `${JSON.stringify(copy, null, 1)}\n`;
  if (process.env.FANLIGHT_UPDATE) writeFileSync(kCopy, text);
  assert.equal(readFileSync(kCopy, "utf8"), text, "run again with FANLIGHT_UPDATE=1");
});

test("every operation answers every role as described", async () => {
  const check = bodyChecker();
  for (const operation of operations().filter((each) => !isStream(each))) {
    const { path, method } = operation;
    const body = exampleOf(operation);
    if (body) check(operation.requestBody.content["application/json"].schema.$ref, body);
    const anonymous = await call(method, path, { body });
    assert.equal(anonymous.status, 401, `${method} ${path} without a token`);
    await checkResponse(operation, anonymous, check);
    for (const role of kRoles) {
      const response = await call(method, path, { role, body });
      const answer = await checkResponse(operation, response, check);
      const may = kRoles.indexOf(role) >= kRoles.indexOf(operation["x-least-role"]);
      assert.equal(response.status === 403, !may, `${method} ${path} by the ${role}: ${JSON.stringify(answer)}`);
      if (!may) assert.equal(answer.type, "urn:fanlight:problem:not-permitted");
      if (answer.key)
        await call("POST", path, { role, body: { wish: "release" }, headers: { "Fanlight-Control": answer.key } });
      if (path === "/api/recording" && answer.file) await call(method, path, { role, body: { wish: "stop" } });
      // The picture of the surface may not show the scene in force yet.
      const isSteady = path !== "/api/surface.html";
      if (method === "GET" && isSteady)
        assert.equal((await call("HEAD", path, { role })).status, response.status, path);
    }
  }
});

test("GET /api and the description have the same operations", async () => {
  const list = await (await call("GET", "/api", { role: "viewer" })).json();
  assert.deepEqual(
    list.operations.map(({ method, path }) => `${method} ${path}`).sort(),
    operations()
      .map(({ method, path }) => `${method} ${path}`)
      .sort(),
  );
});

test("what the description does not have is refused", async () => {
  const check = bodyChecker();
  for (const operation of operations()) {
    const { path, method } = operation;
    const body = exampleOf(operation);
    const query = await call(method, `${path}?unknown=1`, { role: "admin", body });
    // Objects for the archive are judged by their header; here there is no archive.
    assert.equal(query.status, path === "/api/archive" && method === "POST" ? 409 : 400, `${path}?unknown=1`);
    await checkResponse(operation, query, check);
    const twice = await call("OPTIONS", path, { role: "admin" });
    assert.equal(twice.status, 405);
    assert.ok(twice.headers.get("Allow").includes(method), `${path}: ${twice.headers.get("Allow")}`);
    if (!body || path === "/api/archive") continue;
    for (const wrong of [{ ...body, unknown: 1 }, "{", "[1]", '"ask"', "{}"]) {
      const refused = await call(method, path, { role: "admin", body: wrong });
      const problem = await checkResponse(operation, refused, check);
      if (path === "/api/scene" && wrong === "{}") continue; // changes nothing
      assert.ok([400, 422].includes(refused.status), `${path} ${JSON.stringify(wrong)}: ${JSON.stringify(problem)}`);
    }
    const form = await call(method, path, { role: "admin", headers: { "Content-Type": "text/plain" } });
    assert.equal((await checkResponse(operation, form, check)).type, "urn:fanlight:problem:media-type");
  }
  const nothing = await call("GET", "/api/nothing", { role: "viewer" });
  assert.equal(nothing.status, 404);
  check("#/components/schemas/Problem", await nothing.json());
});

test("a value that a field may not have is refused with its range, and nothing is changed", async () => {
  const before = await (await call("GET", "/api/scene", { role: "viewer" })).json();
  const refused = await call("PATCH", "/api/scene", { role: "admin", body: { mode: "volume", light: { up_mm: 1e9 } } });
  assert.equal(refused.status, 422);
  assert.match(refused.headers.get("Content-Type"), /^application\/problem\+json/);
  const problem = await refused.json();
  assert.equal(problem.field, "light.up_mm");
  assert.equal(problem.maximum, 2000);
  assert.deepEqual(await (await call("GET", "/api/scene", { role: "viewer" })).json(), before);
  const { fields } = await (await call("GET", "/api/fields", { role: "viewer" })).json();
  assert.equal(fields.find(({ name }) => name === "light.up_mm").maximum, problem.maximum);
});

test("scripts ask for control, pass it on and release it", async () => {
  const control = (role, body, key) =>
    call("POST", "/api/control", { role, body, headers: key ? { "Fanlight-Control": key } : {} });
  const state = async (key) =>
    (await call("GET", "/api/control", { role: "operator", headers: key ? { "Fanlight-Control": key } : {} })).json();
  const light = (up_mm, key) =>
    call("PATCH", "/api/scene", {
      role: "operator",
      body: { light: { up_mm } },
      headers: key ? { "Fanlight-Control": key } : {},
    });

  const first = await (await control("operator", { wish: "ask", name: "first" })).json();
  assert.ok(first.mine && /^[0-9a-f]{32}$/.test(first.key));
  assert.equal((await light(21)).status, 409, "without the key");
  const held = await (await light(21)).json();
  assert.equal(held.type, "urn:fanlight:problem:control-held");
  assert.match(held.detail, /first .*POST \/api\/control/);
  assert.equal((await light(21, first.key)).status, 200);

  const second = await (await control("operator", { wish: "ask", name: "second" })).json();
  assert.ok(second.waiting && !second.mine);
  const waits = await light(22, second.key);
  assert.equal(waits.status, 409);
  assert.match((await waits.json()).detail, /may wait for it/);
  assert.deepEqual((await state()).asking, [{ session: second.session, name: "second" }]);
  assert.equal((await control("operator", { wish: `grant=${second.session}` }, second.key)).status, 400);
  assert.equal((await control("operator", { wish: `grant=${second.session}` }, first.key)).status, 200);
  assert.ok((await state(second.key)).mine);
  assert.equal((await light(22, second.key)).status, 200);

  assert.equal((await control("operator", { wish: "take_over" })).status, 403);
  assert.equal((await control("viewer", { wish: "ask" })).status, 403);
  const third = await (await control("admin", { wish: "take_over", name: "third" })).json();
  assert.ok(third.mine);
  assert.equal((await light(23, third.key)).status, 409, "the key of another client");
  assert.equal((await control("admin", { wish: "keep" }, third.key)).status, 200);
  assert.equal((await control("admin", { wish: "release" }, third.key)).status, 200);
  const lapsed = await control("admin", { wish: "keep" }, third.key);
  assert.equal(lapsed.status, 409);
  assert.equal((await lapsed.json()).type, "urn:fanlight:problem:control-lapsed");
  for (const [key, owner] of [
    [first.key, "operator"],
    [second.key, "operator"],
  ]) {
    await control(owner, { wish: "release" }, key);
  }
  assert.equal((await state()).holder, null);
  const unknown = await (await control("operator", { wish: "ask", nmae: "x" })).json();
  assert.match(unknown.detail, /the key "nmae"/);
  for (const wish of ["keep", "release", "grant=1", "grant=x", "give", 5]) {
    assert.equal((await control("operator", { wish })).status, 400, wish);
  }
  assert.equal((await control("operator", { wish: "ask", name: 5 })).status, 400);
  assert.equal((await control("operator", { wish: "ask", name: "x".repeat(65) })).status, 400);
});

/** Size of a JPEG file, from its frame header. */
function jpegSize(bytes) {
  for (let at = 2; at < bytes.length - 8; at += 2 + bytes.readUInt16BE(at + 2)) {
    if (bytes[at + 1] >= 0xc0 && bytes[at + 1] <= 0xc2) return [bytes.readUInt16BE(at + 7), bytes.readUInt16BE(at + 5)];
  }
  throw new Error("the picture has no frame header");
}

test("a picture waits for the revision of the scene that is asked for", async () => {
  for (const yaw_deg of [5, 10, 15]) {
    const { revision } = await (
      await call("PATCH", "/api/scene", { role: "admin", body: { camera: { yaw_deg } } })
    ).json();
    for (const path of ["/api/picture.jpg", "/api/picture.png"]) {
      const picture = await call("GET", `${path}?revision=${revision}`, { role: "viewer" });
      assert.ok(Number(picture.headers.get("X-Fanlight-Scene-Revision")) >= revision);
      assert.equal(picture.headers.get("X-Fanlight-Origin"), "simulated");
    }
  }
  const never = await call("GET", "/api/picture.jpg?revision=1000000", { role: "viewer" });
  assert.equal(never.status, 503);
  assert.equal(never.headers.get("Retry-After"), "1");
});

test("pictures come in the size that is asked for", async () => {
  const jpeg = async (query) =>
    Buffer.from(await (await call("GET", `/api/picture.jpg?${query}`, { role: "viewer" })).arrayBuffer());
  assert.deepEqual(jpegSize(await jpeg("size=200x300")), [200, 200]);
  assert.deepEqual(jpegSize(await jpeg("size=2048x2048&t=1")), [512, 512], "no larger than it is");
  assert.ok((await jpeg("quality=20")).length < (await jpeg("quality=95")).length / 2);
  for (const query of [
    "size=5x5",
    "size=x",
    "size=200",
    "quality=0",
    "quality=101",
    "quality=1e9",
    "quality=7.5",
    "revision=-1",
    "revision=x",
    "size=9x9&size=9x9",
    "t=%zz",
  ]) {
    const refused = await call("GET", `/api/picture.jpg?${query}`, { role: "viewer" });
    assert.equal(refused.status, 400, query);
    assert.match((await refused.json()).detail, /expected/);
  }
});

test("the stream has the pictures one after the other, and says where they are not live", async () => {
  const head = await call("HEAD", "/api/stream.mjpeg", { role: "viewer" });
  assert.equal(head.headers.get("Content-Type"), "multipart/x-mixed-replace; boundary=fanlight-picture");
  assert.equal((await call("GET", "/api/stream.mjpeg?rate=0", { role: "viewer" })).status, 400);
  assert.equal((await call("GET", "/api/stream.mjpeg")).status, 401);

  const wish = (word) => call("POST", "/api/cine", { role: "operator", body: { wish: word } });
  await wish("live"); // another test may have frozen it
  const stream = await call("GET", "/api/stream.mjpeg?size=64x64&rate=10", { role: "viewer" });
  let received = Buffer.alloc(0);
  const parts = [];
  const reader = stream.body.getReader();
  while (parts.at(-1)?.liveness !== "frozen") {
    const { value: chunk } = await reader.read();
    received = Buffer.concat([received, chunk]);
    for (;;) {
      const start = received.indexOf("Content-Type");
      const end = received.indexOf("\r\n\r\n", start);
      if (start < 0 || end < 0) break;
      const header = received.subarray(start, end).toString();
      const length = Number(/Content-Length: (\d+)/.exec(header)[1]);
      if (received.length < end + 4 + length + 22) break;
      const jpeg = received.subarray(end + 4, end + 4 + length);
      assert.equal(received.subarray(end + 4 + length, end + 4 + length + 22).toString(), "\r\n--fanlight-picture\r\n");
      parts.push({
        id: Number(/Picture-Id: (\d+)/.exec(header)[1]),
        liveness: /Liveness: (\S+)/.exec(header)[1],
        jpeg,
      });
      received = received.subarray(end + 4 + length);
    }
    if (parts.length === 3) await wish("freeze");
  }
  await reader.cancel();
  await wish("live");
  assert.ok(parts.length > 3, `${parts.length} parts`);
  for (const [index, part] of parts.entries()) {
    assert.deepEqual(jpegSize(part.jpeg), [64, 64]);
    if (index > 0) assert.ok(part.id >= parts[index - 1].id);
  }
  const metrics = await (await call("GET", "/metrics", { role: "viewer" })).text();
  assert.match(metrics, /fanlight_sessions_opened_total [1-9]/);
});

test("the examples of deploy/API.md run, and it has every operation", () => {
  const guide = readFileSync(kGuide, "utf8");
  for (const { method, path } of operations()) {
    assert.ok(guide.includes(`| \`${method} ${path}\``), `deploy/API.md has no row for ${method} ${path}`);
  }
  const script = [...guide.matchAll(/^```sh\n(.*?)^```/gms)].map(([, block]) => block).join("\n");
  assert.ok(script.includes("curl"));
  const environment = { ...process.env, FANLIGHT: server.url.replace(/\/$/, ""), TOKEN: tokens.admin };
  execFileSync("bash", ["-euo", "pipefail", "-c", script], {
    cwd: folder,
    env: environment,
    encoding: "utf8",
    timeout: 60_000,
  });
});
