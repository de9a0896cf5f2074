// SPDX-License-Identifier: Apache-2.0
// Records the pictures that this display receives, and saves them as an MP4 file.
import type { Picture } from "../generated/fanlight_pb.js";
import type { ClipPicture } from "./clip";
import { saveFile, timeInName } from "./save_file";

const kMostS = 60;
const kMostBytes = 200_000_000;
const kLeastApartS = 0.001;

export interface ClipEvents {
  /** Whether pictures can come as H.264 here. */
  canFilm(): boolean;
  /** Asks for H.264 while a clip is recorded, and for what was chosen after it. */
  wantFilm(wanted: boolean): void;
  failed(sentence: string): void;
}

export class ClipButton {
  private pictures: ClipPicture[] | undefined; // absent: no clip is recorded
  private bytes = 0;

  constructor(
    private readonly button: HTMLButtonElement,
    private readonly events: ClipEvents,
  ) {
    button.onclick = () => this.toggle();
  }

  toggle(): void {
    if (this.pictures) return void this.end();
    if (!this.events.canFilm())
      return this.events.failed(
        "A clip needs H.264: a browser that has WebCodecs, and this page over TLS or from localhost.",
      );
    this.pictures = [];
    this.bytes = 0;
    this.events.wantFilm(true);
    this.show(0);
  }

  /** A session has ended: what was recorded is saved. */
  sessionEnded(): void {
    if (this.pictures) void this.end();
  }

  take(picture: Picture): void {
    const { pictures } = this;
    if (!pictures || picture.h264.length === 0) return;
    if (pictures.length === 0 && !picture.keyPicture) return;
    const { h264, keyPicture: isKey, width, height } = picture;
    // A film has one size; a private view's pictures come on the same way as the shared ones.
    if (pictures[0] && (pictures[0].width !== width || pictures[0].height !== height)) return void this.end();
    // Where the view changes, a picture may come that was finished before the last one; later ones depend on it.
    const timeS = Math.max(Number(picture.finishedTimeNs) / 1e9, (pictures.at(-1)?.timeS ?? 0) + kLeastApartS);
    pictures.push({ h264, isKey, timeS, width, height });
    this.bytes += h264.length;
    const lengthS = timeS - pictures[0]!.timeS;
    this.show(lengthS);
    if (lengthS >= kMostS || this.bytes >= kMostBytes) void this.end();
  }

  private async end(): Promise<void> {
    const pictures = this.pictures ?? [];
    this.pictures = undefined;
    this.events.wantFilm(false);
    this.show(0);
    if (pictures.length === 0)
      return this.events.failed("The clip has no picture: none arrived while it was recorded.");
    try {
      const { mp4Of } = (await import("./clip.js")) as typeof import("./clip");
      saveFile(await mp4Of(pictures), `fanlight-${timeInName()}.mp4`);
    } catch (error) {
      this.events.failed(`The clip could not be saved: ${(error as Error).message}`);
    }
  }

  private show(lengthS: number): void {
    const recording = this.pictures !== undefined;
    this.button.ariaPressed = String(recording);
    const text = recording ? `Stop clip ${Math.floor(lengthS)} s` : "Clip";
    if (this.button.textContent?.trim() !== text) this.button.textContent = text;
  }
}
