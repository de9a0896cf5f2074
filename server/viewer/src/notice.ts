// SPDX-License-Identifier: Apache-2.0
// The notice over the picture while it is not live.
import type { SweepWarning } from "../generated/fanlight_pb.js";
import type { LivenessNews } from "./liveness";
import type { LostSince, ProbeNews } from "./probe_watch";

/** Sorted by priority: an earlier condition hides the later ones. */
export interface Condition {
  connection: { state: "connecting" | "open" } | { state: "lost"; sentence: string; retrying: boolean };
  probe: ProbeNews | undefined;
  /** Why a probe that is plugged in is not read; empty: no such reason. */
  probeTrouble?: string;
  serverError: string | undefined;
  liveness: LivenessNews;
  source: string;
  pictureShown: boolean;
  /** A surface is wanted by a threshold from the data, and the frames show speckle only. */
  hasNoSurface?: boolean;
  /** What looks wrong in the frames of the volume that is shown, or of those of the last seconds. */
  warnings?: SweepWarning[];
}

/** What holds before the connection is open. */
export const kNothingKnown: Omit<Condition, "liveness"> = {
  connection: { state: "connecting" },
  probe: undefined,
  serverError: undefined,
  source: "",
  pictureShown: false,
};

export interface NoticeText {
  kind: "connecting" | "lost" | "probe-lost" | "probe-back" | "error" | "not-live" | "waiting";
  title: string;
  detail: string;
}

export function noticeFor(condition: Condition): NoticeText | undefined {
  const { connection, probe, serverError, liveness, source, pictureShown } = condition;
  if (connection.state === "lost") {
    const stale = pictureShown ? " The picture is not live." : "";
    const next = connection.retrying ? " Trying again." : "";
    return { kind: "lost", title: "Connection lost", detail: connection.sentence + stale + next };
  }
  if (connection.state === "connecting") return { kind: "connecting", title: "Connecting", detail: "" };
  if (probe?.state === "lost") return probeLost(probe.since, condition.probeTrouble);
  if (serverError) return { kind: "error", title: "The server reports", detail: serverError };
  if (probe?.state === "back") {
    const detail = probe.pictureShown ? "The picture is live again." : "Waiting for its first volume.";
    return { kind: "probe-back", title: "Probe is back", detail };
  }
  // The amber word and the age say that it is delayed; why is in the word's tooltip.
  if (liveness.title && liveness.state !== "delayed") {
    const still = pictureShown && liveness.state === "not-live" ? " The last volume is still shown." : "";
    return { kind: noticeKind(liveness.state), title: liveness.title, detail: (liveness.detail + still).trim() };
  }
  // Few frames are a property of the protocol: the status line has them.
  const warnings = (condition.warnings ?? []).filter(({ name }) => name !== "sparse");
  if (pictureShown && warnings.length > 0) {
    return { kind: "waiting", title: "Check the probe", detail: warnings.map(({ sentence }) => sentence).join(" ") };
  }
  if (pictureShown && condition.hasNoSurface) {
    const detail = "The frames show speckle only. Check the contact of the probe, and the gain.";
    return { kind: "waiting", title: "No surface", detail };
  }
  if (!pictureShown)
    return { kind: "waiting", title: "No picture yet", detail: `Waiting for a volume from ${source}.` };
  return undefined;
}

function noticeKind(state: LivenessNews["state"]): NoticeText["kind"] {
  if (state === "ended") return "waiting";
  return ["live", "replay", "frozen"].includes(state) ? "error" : "not-live";
}

function probeLost(since: LostSince | undefined, trouble: string | undefined): NoticeText {
  const next = trouble
    ? `The connected device cannot be used: ${trouble}.`
    : "The picture resumes when the probe is connected again.";
  return { kind: "probe-lost", title: "Probe lost", detail: sinceText(since) + next };
}

function sinceText(since: LostSince | undefined): string {
  if (!since) return "";
  const time = new Date(since.wallMs).toTimeString().slice(0, 8);
  return `${since.seen ? "Since" : "Since about"} ${time}. `;
}
