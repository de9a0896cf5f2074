// SPDX-License-Identifier: Apache-2.0
// Watches one mountpoint of Janus's streaming plugin, by Janus's JSON over WebSocket:
// https://janus.conf.meetecho.com/docs/rest. Janus's own janus.js is not used: it tells Janus that a stream whose
// encoded pictures are read is encrypted from end to end, and leaves reconnecting to the page anyway.
import { pictureData } from "./picture_data.js";

const KEEP_ALIVE_MS = 25_000;
const FIRST_PAUSE_MS = 500;
const LONGEST_PAUSE_MS = 5_000;
// Of a connection that brings no picture: the SFU may have been started again.
const SILENT_MS = 10_000;

export class JanusStream {
  #options;
  #socket = null;
  #peer = null;
  #worker = null;
  #session = 0;
  #handle = 0;
  #requests = new Map(); // by transaction
  #timers = [];
  #pause_ms = FIRST_PAUSE_MS;
  #ended = false;
  #heard_ms = 0;

  /**
   * `url`: of Janus, as ws://HOST:8188. `mountpoint`: its id. `pin`: where it has one.
   * Calls onstream(MediaStream), ondata(timestamp, data) for each picture that arrives, and onstate(sentence) with what
   * keeps pictures away; "" where nothing does.
   */
  constructor(options) {
    this.#options = options;
    this.#connect();
  }

  /** Of the connection; null: there is none. */
  get peer() {
    return this.#peer;
  }

  close() {
    this.#ended = true;
    this.#leave();
  }

  #connect() {
    const socket = new WebSocket(this.#options.url, "janus-protocol");
    this.#socket = socket;
    this.#heard_ms = performance.now();
    socket.onopen = () => this.#watch().catch((error) => this.#again(error.message));
    socket.onmessage = (message) => this.#received(JSON.parse(message.data));
    socket.onclose = () => this.#again("the SFU is not there");
    this.#timers.push(
      setInterval(() => {
        if (performance.now() - this.#heard_ms > SILENT_MS) this.#again("no picture comes");
      }, 1_000),
    );
  }

  #leave() {
    for (const timer of this.#timers) clearInterval(timer);
    this.#timers = [];
    if (this.#socket) {
      this.#socket.onclose = this.#socket.onmessage = null;
      this.#socket.close();
    }
    this.#peer?.close();
    this.#worker?.terminate();
    this.#requests.clear();
    this.#socket = this.#peer = this.#worker = null;
  }

  /** Begins again, later each time. */
  #again(reason) {
    if (this.#ended || !this.#socket) return;
    this.#leave();
    this.#options.onstate(`${reason}; tries again`);
    setTimeout(() => !this.#ended && this.#connect(), this.#pause_ms);
    this.#pause_ms = Math.min(2 * this.#pause_ms, LONGEST_PAUSE_MS);
  }

  #send(message) {
    const transaction = crypto.getRandomValues(new Uint32Array(2)).join("");
    if (this.#session) message.session_id = this.#session;
    if (this.#handle && message.janus !== "keepalive") message.handle_id = this.#handle;
    this.#socket?.send(JSON.stringify({ ...message, transaction }));
    return transaction;
  }

  #request(message) {
    return new Promise((resolve, reject) => this.#requests.set(this.#send(message), { resolve, reject }));
  }

  async #watch() {
    this.#session = this.#handle = 0;
    this.#session = (await this.#request({ janus: "create" })).data.id;
    this.#handle = (await this.#request({ janus: "attach", plugin: "janus.plugin.streaming" })).data.id;
    this.#timers.push(setInterval(() => this.#send({ janus: "keepalive" }), KEEP_ALIVE_MS));
    const body = { request: "watch", id: this.#options.mountpoint };
    if (this.#options.pin) body.pin = this.#options.pin;
    this.#send({ janus: "message", body });
  }

  #received(message) {
    const waiting = this.#requests.get(message.transaction);
    if (waiting && message.janus === "success") waiting.resolve(message);
    if (waiting && message.janus === "error") waiting.reject(new Error(message.error.reason));
    if (message.janus !== "ack") this.#requests.delete(message.transaction);
    const refusal = message.plugindata?.data?.error;
    if (refusal) return this.#again(refusal);
    if (message.jsep?.type === "offer") this.#answer(message.jsep).catch((error) => this.#again(error.message));
    if (message.janus === "hangup" || message.janus === "timeout") this.#again("the SFU has ended the connection");
  }

  async #answer(offer) {
    const scripted = "RTCRtpScriptTransform" in globalThis;
    const peer = new RTCPeerConnection({
      iceServers: this.#options.iceServers ?? [],
      ...(scripted ? {} : { encodedInsertableStreams: true }),
    });
    this.#peer = peer;
    peer.onicecandidate = ({ candidate }) =>
      this.#send({ janus: "trickle", candidate: candidate?.toJSON() ?? { completed: true } });
    peer.onconnectionstatechange = () => {
      if (peer.connectionState === "failed") this.#again("the network does not let pictures through");
    };
    peer.ontrack = ({ receiver, track, streams }) => {
      this.#read(receiver, scripted);
      // Each picture is to be shown as soon as it is decoded.
      if ("jitterBufferTarget" in receiver) receiver.jitterBufferTarget = 0;
      this.#options.onstream(streams[0] ?? new MediaStream([track]));
    };
    await peer.setRemoteDescription(offer);
    await peer.setLocalDescription(await peer.createAnswer());
    this.#send({ janus: "message", body: { request: "start" }, jsep: peer.localDescription });
  }

  #arrived(timestamp, data) {
    this.#heard_ms = performance.now();
    this.#pause_ms = FIRST_PAUSE_MS;
    this.#options.onstate("");
    this.#options.ondata(timestamp, data);
  }

  /** Reads the encoded pictures, by the standard's way or by Chromium's older one. */
  #read(receiver, scripted) {
    if (scripted) {
      this.#worker = new Worker(new URL("sei_worker.js", import.meta.url), { type: "module" });
      this.#worker.onmessage = ({ data }) => this.#arrived(data.timestamp, data.data);
      receiver.transform = new RTCRtpScriptTransform(this.#worker, {});
      return;
    }
    const { readable, writable } = receiver.createEncodedStreams();
    const read = new TransformStream({
      transform: (frame, controller) => {
        const data = pictureData(new Uint8Array(frame.data));
        if (data) this.#arrived(frame.getMetadata().rtpTimestamp ?? frame.timestamp, data);
        controller.enqueue(frame);
      },
    });
    readable.pipeThrough(read).pipeTo(writable);
  }
}
