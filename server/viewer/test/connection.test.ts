// SPDX-License-Identifier: Apache-2.0
import { create, fromBinary, toBinary, type MessageInitShape } from "@bufbuild/protobuf";
import assert from "node:assert/strict";
import { test } from "node:test";
import { ClientMessageSchema, ServerMessageSchema } from "../generated/fanlight_pb.js";
import { Connection } from "../src/connection";

class FakeSocket {
  static readonly OPEN = 1;
  static last: FakeSocket;
  readonly readyState = FakeSocket.OPEN;
  readonly sent: (string | undefined)[] = []; // the cases of the messages
  onmessage: ((event: { data: ArrayBuffer }) => void) | null = null;
  onclose: ((event: object) => void) | null = null;

  constructor() {
    FakeSocket.last = this;
  }

  send(bytes: Uint8Array): void {
    this.sent.push(fromBinary(ClientMessageSchema, bytes).body.case);
  }

  close(): void {}

  receive(body: MessageInitShape<typeof ServerMessageSchema>["body"]): void {
    const bytes = toBinary(ServerMessageSchema, create(ServerMessageSchema, body ? { body } : {}));
    this.onmessage?.({ data: bytes.slice().buffer });
  }
}

function opened(): Connection {
  const target = { addEventListener: () => undefined, setInterval: () => 0, setTimeout: () => 0 };
  Object.assign(globalThis, { window: target, document: target, WebSocket: FakeSocket });
  const none = () => undefined;
  const connection = new Connection("ws://127.0.0.1/stream", { connecting: none, message: none, lost: none });
  connection.open();
  return connection;
}

const askClock = (connection: Connection) =>
  connection.send({ case: "clockRequest", value: { clientTimeMs: performance.now() } });

test("before the server's hello only a login is sent", () => {
  const connection = opened();
  askClock(connection);
  FakeSocket.last.receive({ case: "loginNeeded", value: {} });
  askClock(connection);
  connection.send({ case: "login", value: { token: "secret" } });
  askClock(connection);
  assert.deepEqual(FakeSocket.last.sent, ["login"]);
  FakeSocket.last.receive({ case: "hello", value: {} });
  askClock(connection);
  assert.deepEqual(FakeSocket.last.sent, ["login", "clockRequest"]);
});

test("a session after the first one waits for its own hello", () => {
  const connection = opened();
  FakeSocket.last.receive({ case: "hello", value: {} });
  connection.open();
  askClock(connection);
  assert.deepEqual(FakeSocket.last.sent, []);
});
