// SPDX-License-Identifier: Apache-2.0
// The notice over the picture while it is not live.
import type { LostSince, ProbeNews } from "./probe_watch";

const kSilenceMs = 2500; // the server sends the number of frames once a second
const kProbeLost = "probe lost"; // a source state in Statistics; ProbeStatus reports the loss and its end earlier

/** Sorted by priority: an earlier condition hides the later ones. */
export interface Condition {
  connection: { state: "connecting" | "open" } | { state: "lost"; sentence: string; retrying: boolean };
  probe: ProbeNews | undefined;
  /** Why a probe that is plugged in is not read; empty: no such reason. */
  probeTrouble?: string;
  serverError: string | undefined;
  /** Seconds since the last frame; undefined if shorter than kSilenceMs. */
  silentSeconds: number | undefined;
  source: string;
  /** "running", "probe lost", "ended", or the reason of its failure as a sentence. */
  sourceState: string;
  pictureShown: boolean;
}

export interface NoticeText {
  kind: "connecting" | "lost" | "probe-lost" | "probe-back" | "error" | "silent" | "waiting";
  title: string;
  detail: string;
}

export function noticeFor(condition: Condition): NoticeText | undefined {
  const { connection, probe, probeTrouble, serverError, silentSeconds, source, sourceState, pictureShown } = condition;
  if (connection.state === "lost") {
    const stale = pictureShown ? " The picture is not live." : "";
    const next = connection.retrying ? " Trying again." : "";
    return { kind: "lost", title: "Connection lost", detail: connection.sentence + stale + next };
  }
  if (connection.state === "connecting") return { kind: "connecting", title: "Connecting", detail: "" };
  if (probe?.state === "lost") {
    const next = probeTrouble
      ? `What is plugged in now is not read: ${probeTrouble}.`
      : "The picture goes on by itself when the probe is plugged in again.";
    const detail = sinceText(probe.since) + next;
    return { kind: "probe-lost", title: "Probe lost", detail };
  }
  if (serverError) return { kind: "error", title: "The server reports", detail: serverError };
  const still = pictureShown ? " The last volume stays on display." : "";
  if (sourceState === "ended") {
    return { kind: "silent", title: "The source has ended", detail: `${source} has no more frames.${still}` };
  }
  if (sourceState !== "running" && sourceState !== kProbeLost)
    return { kind: "error", title: "The source has failed", detail: sourceState };
  if (probe?.state === "back") {
    const detail = probe.pictureShown ? "The picture is live again." : "Waiting for its first volume.";
    return { kind: "probe-back", title: "Probe is back", detail };
  }
  if (silentSeconds !== undefined) {
    return {
      kind: "silent",
      title: "No new frames",
      detail: `None from ${source} for ${duration(silentSeconds)}.${still}`,
    };
  }
  if (!pictureShown)
    return { kind: "waiting", title: "No picture yet", detail: `Waiting for a volume from ${source}.` };
  return undefined;
}

/** Measures for how long the number of frames has not changed. */
export class FrameWatch {
  private frames = -1n;
  private sinceMs = 0;

  count(frames: bigint, nowMs: number): void {
    if (frames === this.frames) return;
    this.frames = frames;
    this.sinceMs = nowMs;
  }

  reset(): void {
    this.frames = -1n;
  }

  silentSeconds(nowMs: number): number | undefined {
    const silentMs = nowMs - this.sinceMs;
    return this.frames < 0n || silentMs < kSilenceMs ? undefined : Math.floor(silentMs / 1000);
  }
}

/** "Not live, 48 s old": the mark on a picture that is not live. */
export function notLiveText(ageMs: number | undefined): string {
  return ageMs === undefined ? "Not live" : `Not live, ${duration(Math.floor(ageMs / 1000))} old`;
}

function sinceText(since: LostSince | undefined): string {
  if (!since) return "";
  const time = new Date(since.wallMs).toTimeString().slice(0, 8);
  return `${since.seen ? "Since" : "Since about"} ${time}. `;
}

function duration(seconds: number): string {
  if (seconds < 60) return `${seconds} s`;
  return seconds < 3600 ? `${Math.floor(seconds / 60)} min` : `${Math.floor(seconds / 3600)} h`;
}
