// SPDX-License-Identifier: Apache-2.0
// Shows what the server's recorder does, and the buttons that start, stop and keep a recording.
import {
  RecordingRequest_Wish as Wish,
  RecordingStatus_State as State,
  type RecordingStatus,
} from "../generated/fanlight_pb.js";

export interface RecordingText {
  text: string;
  /** "recording" and "trouble" are shown in colour. */
  kind: "quiet" | "recording" | "trouble";
  /** The wish of the first button. */
  wish: Wish;
  /** Whether the button "Keep" is offered. */
  keeps: boolean;
}

/** undefined: this server records nothing. */
export function recordingText(status: RecordingStatus): RecordingText | undefined {
  if (!status.available) return undefined;
  const recording = status.state === State.RECORDING && !status.ring;
  const halted = status.state === State.NO_ROOM;
  const stops = recording || (halted && !status.ring);
  const told = { wish: stops ? Wish.STOP : Wish.START, keeps: status.ring && !halted };
  if (halted) return { ...told, text: `Not recording: ${status.trouble}`, kind: "trouble" };
  if (recording) {
    const missed = status.framesMissed > 0n ? `, ${status.framesMissed} frames missed` : "";
    return {
      ...told,
      text: `Recording ${timeText(status.durationS)}, ${sizeText(Number(status.bytes))}${missed}`,
      kind: missed ? "trouble" : "recording",
    };
  }
  if (status.lastTrouble) return { ...told, text: `Not saved: ${status.lastTrouble}`, kind: "trouble" };
  if (status.state === State.FINISHING) {
    return { ...told, text: `Saving ${status.file}, ${Math.round(100 * status.finishShare)} %`, kind: "quiet" };
  }
  const saved = status.lastFile ? `Saved ${status.lastFile}` : "";
  return { ...told, text: saved, kind: "quiet" };
}

/** 83 -> "1:23" */
function timeText(seconds: number): string {
  const whole = Math.floor(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

function sizeText(bytes: number): string {
  return bytes < 1e9 ? `${(bytes / 1e6).toFixed(0)} MB` : `${(bytes / 1e9).toFixed(1)} GB`;
}

/** 180 -> "3 min" */
function spanText(seconds: number): string {
  return seconds < 60 ? `${Math.round(seconds)} s` : `${Math.round(seconds / 6) / 10} min`;
}

export class RecordingBar {
  private readonly text: Element;
  private readonly main: HTMLButtonElement;
  private readonly keep: HTMLButtonElement;
  private lastId = 0n;

  constructor(
    private readonly root: HTMLElement,
    ask: (requestId: bigint, wish: Wish) => void,
  ) {
    const [main, keep, text] = root.children;
    if (!text || !(main instanceof HTMLButtonElement) || !(keep instanceof HTMLButtonElement))
      throw new Error("The page has no place for the recording.");
    [this.text, this.main, this.keep] = [text, main, keep];
    main.onclick = () => ask((this.lastId += 1n), Number(main.value) as Wish);
    keep.onclick = () => ask((this.lastId += 1n), Wish.KEEP);
  }

  tell(status: RecordingStatus): void {
    const told = recordingText(status);
    this.root.hidden = !told;
    if (!told) return;
    this.root.dataset.kind = told.kind;
    // A screen reader announces every write.
    if (this.text.textContent !== told.text) this.text.textContent = told.text;
    const label = told.wish === Wish.STOP ? "Stop" : "Record";
    if (this.main.textContent !== label) this.main.textContent = label;
    this.main.value = String(told.wish);
    this.keep.hidden = !told.keeps;
    this.keep.textContent = `Keep the last ${spanText(status.keepsLastS)}`;
  }

  /** Whether this display may start and stop recordings now. */
  allow(may: boolean): void {
    this.main.disabled = this.keep.disabled = !may;
  }
}
