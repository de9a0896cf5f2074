// SPDX-License-Identifier: Apache-2.0
// The session of a <fanlight-view> with its server: logs in, asks for pictures of the wanted size, and follows what has
// to be said beside them.
import type { Hello, Picture, Scene, ServerMessage, ViewState } from "../../generated/fanlight_pb.js";
import { Connection, streamUrl, type ClientBody } from "../connection";
import { LivenessWatch } from "../liveness";
import { kNothingKnown, type Condition } from "../notice";
import { ProbeWatch } from "../probe_watch";
import { RecentWarnings } from "../recent_warnings";
import { ServerClock } from "../server_clock";
import type { Size } from "../view_geometry";

const kProtocolVersion = 2;
const kClockMs = 500;
/** What a request may contain. */
const [kLeastSide, kMostSide] = [16, 4096];

export interface SessionWish {
  /** The address of the server's page, absolute. */
  server: string;
  token: string;
  /** What other displays see; empty: the name of the token. */
  name: string;
  /** Pictures a second at most; 0: each one. */
  rateHz: number;
}

export interface SessionEvents {
  hello(hello: Hello): void;
  /** The main scene has changed. */
  scene(scene: Scene): void;
  picture(picture: Picture): void;
  /** The private view of this session has changed, or has ended. */
  view(state: ViewState): void;
  viewRefused(sentence: string): void;
  /** Something of condition() has changed. */
  changed(): void;
}

export class PictureSession {
  /** Why the server lets this display see nothing; empty: it has not refused. No further attempt is made. */
  refusal = "";
  /** The pictures are sent to displays beyond the room. */
  isRelayed = false;
  private readonly clock = new ServerClock();
  private readonly liveness = new LivenessWatch((pageMs) => this.clock.at(pageMs));
  private readonly warnings = new RecentWarnings();
  private readonly probe = new ProbeWatch(
    (pageMs) => this.clock.at(pageMs),
    (pageMs) => Date.now() - performance.now() + pageMs,
  );
  private readonly connection: Connection;
  private readonly clockTimer: number;
  private known: Omit<Condition, "liveness"> = kNothingKnown;
  private usual: Size | undefined; // of the pictures; undefined before the Hello
  private asked = "";
  private wanted: Size = { width: 0, height: 0 };

  constructor(
    private readonly wish: SessionWish,
    private readonly events: SessionEvents,
  ) {
    this.connection = new Connection(streamUrl(wish.server), {
      connecting: () => this.now({ connection: { state: "connecting" } }),
      message: (message) => this.receive(message),
      lost: (sentence) => this.lost({ state: "lost", sentence, retrying: true }),
    });
    this.clockTimer = window.setInterval(() => this.askClock(), kClockMs);
    this.connection.open();
  }

  dispose(): void {
    window.clearInterval(this.clockTimer);
    this.connection.dispose();
  }

  send(body: ClientBody): void {
    this.connection.send(body);
  }

  condition(): Condition {
    const nowMs = performance.now();
    const liveness = this.liveness.news(nowMs);
    // After a probe's return only a volume from after it is live.
    if (liveness.state === "live" && !this.probe.isLive()) liveness.state = "not-live";
    return { ...this.known, liveness, probe: this.probe.news(nowMs), warnings: this.warnings.recent(nowMs) };
  }

  /** Pixels of the screen that the picture covers. The server is asked for no more than it renders usually. */
  setSize(size: Size): void {
    this.wanted = size;
    this.askPictures();
  }

  shown(picture: Picture): void {
    const capturedMs = Number(picture.captureTimeNs) / 1e6;
    for (const each of [this.probe, this.liveness]) each.show(capturedMs);
    this.warnings.take(picture.warnings, performance.now());
    this.now({ pictureShown: true, serverError: undefined });
  }

  unreadable(sentence: string): void {
    this.now({ serverError: sentence });
  }

  private now(change: Partial<Condition>): void {
    this.known = { ...this.known, ...change };
    this.events.changed();
  }

  private lost(connection: Condition["connection"]): void {
    this.usual = undefined;
    this.asked = "";
    this.isRelayed = false;
    this.now({ connection, serverError: undefined });
  }

  private refuse(sentence: string): void {
    this.refusal = sentence;
    this.connection.dispose();
    this.lost({ state: "lost", sentence, retrying: false });
  }

  private askClock(): void {
    this.connection.send({ case: "clockRequest", value: { clientTimeMs: performance.now() } });
  }

  private askPictures(): void {
    if (!this.usual) return;
    const { width, height } = this.wanted;
    const less = Math.min(1, this.usual.width / Math.max(1, width), this.usual.height / Math.max(1, height));
    const side = (pixels: number) => Math.min(kMostSide, Math.max(kLeastSide, Math.round(less * pixels)));
    const value = { width: side(width), height: side(height), rateHz: this.wish.rateHz };
    const asked = JSON.stringify(value);
    if (asked === this.asked) return;
    this.asked = asked;
    this.connection.send({ case: "stream", value });
  }

  private receive({ body }: ServerMessage): void {
    this.liveness.heard(performance.now());
    switch (body.case) {
      case "loginNeeded":
        if (!this.wish.token) return this.refuse("The server asks for a token.");
        return this.connection.send({ case: "login", value: { token: this.wish.token, name: this.wish.name } });
      case "hello":
        return this.begin(body.value);
      case "picture":
        return this.events.picture(body.value);
      case "scene":
        return body.value.scene && this.events.scene(body.value.scene);
      case "view":
        return this.events.view(body.value);
      case "viewReply":
        if (body.value.outcome.case === "inForce") return this.events.view(body.value.outcome.value);
        return this.events.viewRefused(body.value.outcome.value?.message ?? "");
      case "clockReply":
        return this.clock.add(body.value.clientTimeMs, body.value.serverTimeNs, performance.now());
      case "liveness":
        this.liveness.tell(body.value);
        return this.events.changed();
      case "probeStatus":
        this.probe.tell(body.value.state, performance.now());
        return this.now({ probeTrouble: body.value.trouble });
      case "relay":
        this.isRelayed = body.value.sending;
        return this.events.changed();
      case "streamReply":
        if (body.value.outcome.case !== "refused") return;
        return this.now({ serverError: body.value.outcome.value.message });
      case "error":
        // Before the Hello it is the answer to the login.
        if (!this.usual) return this.refuse(body.value.message);
        return this.now({ serverError: body.value.message });
    }
  }

  private begin(hello: Hello): void {
    if (hello.protocolVersion !== kProtocolVersion) {
      const versions = `The server speaks protocol ${hello.protocolVersion}, this display ${kProtocolVersion}`;
      return this.refuse(`${versions}: load fanlight-view.js from the server.`);
    }
    this.clock.reset();
    this.probe.reset();
    this.liveness.reset(performance.now());
    this.usual = { width: hello.pictureWidth, height: hello.pictureHeight };
    this.askClock();
    if (this.wish.name) this.connection.send({ case: "login", value: { name: this.wish.name } });
    this.events.hello(hello);
    this.askPictures();
    this.now({ connection: { state: "open" }, source: hello.title || hello.source, pictureShown: false });
  }
}
