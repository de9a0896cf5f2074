// SPDX-License-Identifier: Apache-2.0
// Whether the picture on this display is live, and what to say where it is not.
import { Liveness_Cause, Liveness_Origin, Liveness_State, type Liveness } from "../generated/fanlight_pb.js";

const kReplay = /^The replay/; // a sentence about a frozen one
const kSilenceMs = 2000; // the server sends a message once a second at least
const kUsualLimitMs = 2000; // until the server has sent its own

const kDelayedMs = 3000; // after the last late picture
const kThawMs = 3000; // until a new volume replaces a frozen one

export interface LivenessNews {
  state: "waiting" | "live" | "delayed" | "not-live" | "replay" | "ended" | "frozen";
  /** From the capture of the volume shown to now; undefined without a picture, or while the clock is unknown. */
  ageMs: number | undefined;
  /** What keeps new pictures away: a title and a sentence; both empty where the picture is live. */
  title: string;
  detail: string;
  /** Of a live picture: where its frames come from, where that is no probe that is known to be one. */
  origin?: "unverified" | "simulated";
  /** Of a frozen picture: it is one of a recording. */
  isReplay?: boolean;
  /** Of a frozen picture: it is frozen on this display alone. */
  isOwn?: boolean;
}

const kTitles: Record<Liveness_Cause, string> = {
  [Liveness_Cause.NONE]: "",
  [Liveness_Cause.SOURCE_FAILED]: "The source has failed",
  [Liveness_Cause.SOURCE_ENDED]: "The recording has ended",
  [Liveness_Cause.PROBE_LOST]: "Probe lost",
  [Liveness_Cause.GPU_REMADE]: "The GPU is started again",
  [Liveness_Cause.GPU_HUNG]: "The GPU does not answer",
  [Liveness_Cause.NO_FRAMES]: "No new frames",
  [Liveness_Cause.VOLUMES_REFUSED]: "Volumes refused",
  [Liveness_Cause.RENDERER_BEHIND]: "No new pictures",
  [Liveness_Cause.SWEEPS_DROPPED]: "No complete sweep",
  [Liveness_Cause.NO_SWEEP]: "No complete sweep",
  [Liveness_Cause.DRIVER_SILENT]: "The GPU's driver does not answer",
  [Liveness_Cause.CHANGE_NOT_SHOWN]: "Settings not applied",
};

const kOrigins: Partial<Record<Liveness_Origin, LivenessNews["origin"]>> = {
  [Liveness_Origin.UNKNOWN]: "unverified",
  [Liveness_Origin.SIMULATED]: "simulated",
};

/**
 * Joins what the server says of its newest picture, the age of the picture on this display, and the server's silence.
 * Times are performance.now() of the page, except where the name says another clock.
 */
export class LivenessWatch {
  private told: Liveness | undefined;
  private heardMs = 0;
  private capturedServerMs: number | undefined;
  private held = false;
  private thawingSinceMs = -Infinity; // since when nothing is frozen; a frozen picture may still be on show
  private delayed: { sinceMs: number; detail: string } | undefined;

  /** `serverMs` converts a time of the page to the server's clock; undefined while that is unknown. */
  constructor(private readonly serverMs: (pageMs: number) => number | undefined) {}

  /** Call at the start of a session. */
  reset(nowMs: number): void {
    this.told = this.capturedServerMs = this.delayed = undefined;
    this.thawingSinceMs = -Infinity;
    this.heardMs = nowMs;
  }

  /** Call for each message of the server. */
  heard(nowMs: number): void {
    this.heardMs = nowMs;
  }

  /** This display keeps its picture, whatever the server shows. */
  hold(held: boolean, nowMs = performance.now()): void {
    if (this.held && !held) this.thawingSinceMs = nowMs;
    this.held = held;
  }

  tell(liveness: Liveness, nowMs = performance.now()): void {
    if (this.told?.state === Liveness_State.FROZEN && liveness.state !== Liveness_State.FROZEN)
      this.thawingSinceMs = nowMs;
    this.told = liveness;
  }

  /** Call for each picture shown. */
  show(capturedServerMs: number): void {
    this.capturedServerMs = capturedServerMs;
  }

  /** What is shown was captured at another time than the server's clock says. */
  get isReplay(): boolean {
    const { state, origin, sentence } = this.told ?? {};
    return state === Liveness_State.REPLAY || origin === Liveness_Origin.RECORDING || kReplay.test(sentence ?? "");
  }

  news(nowMs: number): LivenessNews {
    const news = this.steadyNews(nowMs);
    const detail = this.told?.sceneTrouble;
    if (!detail || news.title) return news;
    return { ...news, title: kTitles[Liveness_Cause.CHANGE_NOT_SHOWN], detail };
  }

  /** A picture that was delayed is so until pictures have been in time for a while: the word does not flicker. */
  private steadyNews(nowMs: number): LivenessNews {
    const news = this.stateNews(nowMs);
    if (news.state === "delayed") this.delayed = { sinceMs: nowMs, detail: news.detail };
    else if (news.state !== "live") this.delayed = undefined;
    if (news.state !== "live" || !this.delayed || nowMs - this.delayed.sinceMs > kDelayedMs) return news;
    return { state: "delayed", ageMs: news.ageMs, title: "Delayed", detail: this.delayed.detail };
  }

  /** Without a change that is not shown, which is reported beside any state. */
  private stateNews(nowMs: number): LivenessNews {
    const ageMs = this.ageMs(nowMs);
    const shown = this.capturedServerMs !== undefined;
    const still = { state: shown ? "not-live" : "waiting", ageMs } as const;
    const silentMs = nowMs - this.heardMs;
    if (silentMs > kSilenceMs) {
      const detail = `No data for ${duration(silentMs / 1000)}.`;
      return { ...still, title: "The server does not answer", detail };
    }
    if (this.held && shown) return { state: "frozen", ageMs, title: "", detail: "", isOwn: true };
    const { sentence, state } = this.told ?? {};
    const cause = this.told?.cause === Liveness_Cause.CHANGE_NOT_SHOWN ? Liveness_Cause.NONE : this.told?.cause;
    if (state === Liveness_State.FROZEN && shown) {
      const title = cause ? kTitles[cause] : "";
      const isReplay = kReplay.test(sentence ?? "");
      const detail = cause ? (sentence ?? "").replace(/^The (picture|replay of a recording) is frozen\. ?/, "") : "";
      const rest = withoutTitle(detail, title);
      return {
        state: "frozen",
        ageMs: isReplay ? undefined : ageMs,
        title,
        detail: rest,
        ...(isReplay && { isReplay }),
      };
    }
    // The last picture of a recording is no less true after its end.
    if (cause === Liveness_Cause.SOURCE_ENDED && this.isReplay && shown)
      return { state: "ended", ageMs: undefined, title: kTitles[cause], detail: "The last volume is still shown." };
    if (cause) {
      const title = kTitles[cause] || "No new pictures";
      return { ...still, title, detail: withoutTitle(sentence ?? "", title) };
    }
    if (!shown) return { ...still, title: "", detail: "" };
    if (state === Liveness_State.REPLAY) return { state: "replay", ageMs: undefined, title: "", detail: "" };
    const late = ageMs !== undefined && ageMs > this.limitMs();
    if (!late) this.thawingSinceMs = -Infinity; // a new one has come
    if (late && nowMs - this.thawingSinceMs < kThawMs) return { state: "frozen", ageMs, title: "", detail: "" };
    if (state === Liveness_State.DELAYED) return { state: "delayed", ageMs, title: "Delayed", detail: sentence ?? "" };
    if (late) return { state: "delayed", ageMs, title: "Delayed", detail: "Pictures reach this display late." };
    const origin = this.told && kOrigins[this.told.origin];
    return { state: "live", ageMs, title: "", detail: "", ...(origin && { origin }) };
  }

  private limitMs(): number {
    return this.told?.limitS ? this.told.limitS * 1000 : kUsualLimitMs;
  }

  private ageMs(nowMs: number): number | undefined {
    const serverMs = this.serverMs(nowMs);
    if (serverMs === undefined || this.capturedServerMs === undefined) return undefined;
    return Math.max(0, serverMs - this.capturedServerMs);
  }
}

/** The sentence, without a beginning that says the same as the title. */
function withoutTitle(sentence: string, title: string): string {
  return sentence.startsWith(title) ? sentence.slice(title.length).replace(/^[.:] ?/, "") : sentence;
}

const kWords: Record<LivenessNews["state"], string> = {
  waiting: "Waiting",
  live: "Live",
  delayed: "Delayed",
  "not-live": "Lost",
  replay: "Replay",
  ended: "Replay ended",
  frozen: "Frozen",
};

/** The word for the state, always at the same place. */
export function stateWord({ state, origin }: Pick<LivenessNews, "state" | "origin">): string {
  if (origin === "simulated") return "Simulated";
  return origin === "unverified" ? "Live, unverified" : kWords[state];
}

/** "0.4 s", "48 s", "2 min": the age of a picture. */
export function ageText(ageMs: number | undefined): string {
  if (ageMs === undefined) return "";
  return ageMs < 9_950 ? `${(ageMs / 1000).toFixed(1)} s` : duration(ageMs / 1000);
}

/** The mark on a picture: "Lost, 48 s old", "Delayed 3.1 s", "Replay"; empty on a live one. */
export function markText({ state, ageMs, isReplay, isOwn }: LivenessNews): string {
  const word = kWords[state];
  if (state === "live") return "";
  if (isOwn) return `Frozen on this display only${ageMs === undefined ? "" : `, ${duration(ageMs / 1000)} old`}`;
  if (isReplay) return `${word}, replay`;
  if (ageMs === undefined) return word;
  return state === "delayed" ? `Delayed ${ageText(ageMs)}` : `${word}, ${duration(ageMs / 1000)} old`;
}

export function duration(seconds: number): string {
  if (seconds < 60) return `${Math.floor(seconds)} s`;
  return seconds < 3600 ? `${Math.floor(seconds / 60)} min` : `${Math.floor(seconds / 3600)} h`;
}
