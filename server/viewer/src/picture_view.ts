// SPDX-License-Identifier: Apache-2.0
// The canvas. At most one picture is decoded and at most one waits, the newest. H.264 pictures are all decoded.
import type { Picture } from "../generated/fanlight_pb.js";
import { FilmDecoder } from "./film_decoder";

export class PictureView {
  private decoding = false;
  private waiting: Picture | undefined;
  private held = false;
  private readonly context: CanvasRenderingContext2D;
  private readonly film: FilmDecoder;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly frame: HTMLElement,
    private readonly shown: (picture: Picture) => void,
    private readonly unreadable: (sentence: string) => void,
    filmFailed: () => void,
  ) {
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("This browser has no 2D canvas.");
    this.context = context;
    this.film = new FilmDecoder((frame, picture) => {
      if (this.held) return;
      this.draw(frame, frame.displayWidth, frame.displayHeight);
      this.shown(picture);
    }, filmFailed);
  }

  /** Keeps the picture on this display as it is; a film is decoded on, since its next pictures depend on these. */
  hold(held: boolean): void {
    this.held = held;
    if (held) this.waiting = undefined;
  }

  show(picture: Picture): void {
    if (picture.h264.length > 0) return this.film.decode(picture);
    this.film.end();
    if (this.held) return;
    this.waiting = picture;
    if (!this.decoding) void this.decode();
  }

  private async decode(): Promise<void> {
    this.decoding = true;
    while (this.waiting) {
      const picture = this.waiting;
      this.waiting = undefined;
      try {
        const bitmap = await createImageBitmap(blobOf(picture));
        if (!this.held) this.draw(bitmap, bitmap.width, bitmap.height);
        bitmap.close();
        if (!this.held) this.shown(picture);
      } catch {
        this.unreadable(`Picture ${picture.pictureId} could not be decoded.`);
      }
    }
    this.decoding = false;
  }

  private draw(image: CanvasImageSource, width: number, height: number): void {
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.frame.style.setProperty("--aspect", String(width / height));
    }
    this.context.drawImage(image, 0, 0);
    this.frame.hidden = false;
  }
}

function blobOf(picture: Picture): Blob {
  return picture.png.length > 0
    ? new Blob([picture.png], { type: "image/png" })
    : new Blob([picture.jpeg], { type: "image/jpeg" });
}
