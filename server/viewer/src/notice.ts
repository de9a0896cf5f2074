// What the stage says when it does not show a living picture.

const kSilenceMs = 2500; // the count of frames comes once a second

/** In the order in which one hides another. */
export interface Condition {
  connection: { state: "connecting" | "open" } | { state: "lost"; sentence: string; retrying: boolean };
  serverError: string | undefined;
  /** Seconds since the last frame came in, where that is worth saying. */
  silentSeconds: number | undefined;
  source: string;
  /** "running", "ended", or the sentence on why it failed. */
  sourceState: string;
  pictureShown: boolean;
}

export interface NoticeText {
  kind: "connecting" | "lost" | "error" | "silent" | "waiting";
  title: string;
  detail: string;
}

export function noticeFor(condition: Condition): NoticeText | undefined {
  const { connection, serverError, silentSeconds, source, sourceState, pictureShown } = condition;
  if (connection.state === "lost") {
    const stale = pictureShown ? " The picture is not live." : "";
    const next = connection.retrying ? " Trying again." : "";
    return { kind: "lost", title: "Connection lost", detail: connection.sentence + stale + next };
  }
  if (connection.state === "connecting") return { kind: "connecting", title: "Connecting", detail: "" };
  if (serverError) return { kind: "error", title: "The server reports", detail: serverError };
  const still = pictureShown ? " The last volume stays on display." : "";
  if (sourceState === "ended") {
    return { kind: "silent", title: "The source has ended", detail: `${source} has no more frames.${still}` };
  }
  if (sourceState !== "running") return { kind: "error", title: "The source has failed", detail: sourceState };
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

/** Notices how long the count of frames has stood still. */
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

function duration(seconds: number): string {
  return seconds < 60 ? `${seconds} s` : `${Math.floor(seconds / 60)} min`;
}
