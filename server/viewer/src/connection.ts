// SPDX-License-Identifier: Apache-2.0
// The WebSocket to the server. It reconnects whenever the connection is lost.
import { create, fromBinary, toBinary, type MessageInitShape } from "@bufbuild/protobuf";
import { ClientMessageSchema, ServerMessageSchema, type ServerMessage } from "../generated/fanlight_pb.js";

const kProtocol = "fanlight.v2";
const kFirstRetryMs = 500;
const kLongestRetryMs = 2000;
// The server sends statistics once a second. A session silent for so long is dead, even if TCP has not noticed.
const kSilenceMs = 5000;
const kSilenceCheckMs = 1000;

export type ClientBody = MessageInitShape<typeof ClientMessageSchema>["body"];

export interface ConnectionEvents {
  connecting(): void;
  message(message: ServerMessage): void;
  lost(sentence: string): void;
}

export class Connection {
  private socket: WebSocket | undefined;
  private retryMs = kFirstRetryMs;
  private heardMs = 0;
  private isWelcome = false; // the server has said hello: it accepts other messages than a login
  private retryTimer = 0; // 0: no try is due
  private readonly silenceTimer: number;
  private readonly online = () => this.retryNow();
  private readonly visible = () => {
    if (document.visibilityState === "visible") this.retryNow();
  };

  constructor(
    private readonly url: string,
    private readonly events: ConnectionEvents,
  ) {
    this.silenceTimer = window.setInterval(() => this.closeWhenSilent(), kSilenceCheckMs);
    // The network is back, or the user is: no need to wait for a timer then.
    window.addEventListener("online", this.online);
    document.addEventListener("visibilitychange", this.visible);
  }

  open(): void {
    this.events.connecting();
    const socket = new WebSocket(this.url, kProtocol);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.heardMs = performance.now();
    this.isWelcome = false;
    let heard = false;
    socket.onmessage = (event: MessageEvent<ArrayBuffer>) => {
      heard = true;
      this.retryMs = kFirstRetryMs;
      this.heardMs = performance.now();
      const message = fromBinary(ServerMessageSchema, new Uint8Array(event.data));
      if (message.body.case === "hello") this.isWelcome = true;
      this.events.message(message);
    };
    socket.onclose = (event) => this.retry(lossSentence(event, heard));
  }

  /**
   * Messages are discarded while the connection is down. So is all but a login before the server's hello: the server
   * would refuse it, and the page would show that as the answer to the login.
   */
  send(body: ClientBody): void {
    if (this.socket?.readyState !== WebSocket.OPEN || !body) return;
    if (!this.isWelcome && body.case !== "login") return;
    this.socket.send(toBinary(ClientMessageSchema, create(ClientMessageSchema, { body })));
  }

  /** Closes without reconnecting. */
  end(): void {
    if (this.socket) this.drop(this.socket);
    this.socket = undefined;
  }

  /** Ends it for good: it cannot be opened any more. */
  dispose(): void {
    this.end();
    window.clearTimeout(this.retryTimer);
    window.clearInterval(this.silenceTimer);
    window.removeEventListener("online", this.online);
    document.removeEventListener("visibilitychange", this.visible);
  }

  private closeWhenSilent(): void {
    const socket = this.socket;
    if (!socket || performance.now() - this.heardMs < kSilenceMs) return;
    this.drop(socket);
    this.retry("The server does not respond.");
  }

  /** Does not wait for the closing handshake, which takes long if the peer is dead. */
  private drop(socket: WebSocket): void {
    socket.onclose = null;
    socket.onmessage = null;
    socket.close();
  }

  private retryNow(): void {
    if (this.retryTimer === 0) return;
    window.clearTimeout(this.retryTimer);
    this.retryTimer = 0;
    this.open();
  }

  private retry(sentence: string): void {
    this.socket = undefined;
    this.events.lost(sentence);
    this.retryTimer = window.setTimeout(() => this.retryNow(), this.retryMs);
    this.retryMs = Math.min(kLongestRetryMs, this.retryMs * 2);
  }
}

function lossSentence(event: CloseEvent, heard: boolean): string {
  if (event.reason) return `The server closed the session: ${event.reason.replace(/\.$/, "")}.`;
  if (event.wasClean) return "The server closed the session.";
  return heard ? "The connection broke." : "The server does not answer.";
}

/** Relative to the page of the server, so that it also works behind a reverse proxy with a path prefix. */
export function streamUrl(page: string = document.baseURI): string {
  const url = new URL("stream", page);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  return url.href;
}
