// The canvas. At most one picture is being decoded and at most one waits, the newest.
import type { Picture } from "../generated/fanlight_pb.js";

export class PictureView {
  private decoding = false;
  private waiting: Picture | undefined;
  private readonly context: CanvasRenderingContext2D;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly frame: HTMLElement,
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

  private async decode(): Promise<void> {
    this.decoding = true;
    while (this.waiting) {
      const picture = this.waiting;
      this.waiting = undefined;
      try {
        const bitmap = await createImageBitmap(new Blob([picture.jpeg], { type: "image/jpeg" }));
        this.draw(bitmap);
        bitmap.close();
        this.shown(picture);
      } catch {
        this.unreadable(`Picture ${picture.pictureId} could not be decoded.`);
      }
    }
    this.decoding = false;
  }

  private draw(bitmap: ImageBitmap): void {
    if (this.canvas.width !== bitmap.width || this.canvas.height !== bitmap.height) {
      this.canvas.width = bitmap.width;
      this.canvas.height = bitmap.height;
      this.frame.style.setProperty("--aspect", String(bitmap.width / bitmap.height));
    }
    this.context.drawImage(bitmap, 0, 0);
    this.frame.hidden = false;
  }
}
