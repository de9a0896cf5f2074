// SPDX-License-Identifier: Apache-2.0
// Draws the server's pictures. At most one is decoded and at most one waits, the newest.
import type { Picture } from "../../generated/fanlight_pb.js";

export class NewestPicture {
  private waiting: Picture | undefined;
  private decoding = false;
  private readonly context: CanvasRenderingContext2D;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly shown: (picture: Picture) => void,
    private readonly unreadable: (sentence: string) => void,
  ) {
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("This browser has no 2D canvas.");
    this.context = context;
  }

  show(picture: Picture): void {
    this.waiting = picture;
    if (!this.decoding) void this.decode();
  }

  /** Drops what waits; the canvas keeps its picture. */
  forget(): void {
    this.waiting = undefined;
  }

  private async decode(): Promise<void> {
    this.decoding = true;
    while (this.waiting) {
      const picture = this.waiting;
      this.waiting = undefined;
      try {
        const bitmap = await createImageBitmap(new Blob([picture.jpeg], { type: "image/jpeg" }));
        if (this.canvas.width !== bitmap.width) this.canvas.width = bitmap.width;
        if (this.canvas.height !== bitmap.height) this.canvas.height = bitmap.height;
        this.context.drawImage(bitmap, 0, 0);
        bitmap.close();
        this.shown(picture);
      } catch {
        this.unreadable(`Picture ${picture.pictureId} could not be decoded.`);
      }
    }
    this.decoding = false;
  }
}
