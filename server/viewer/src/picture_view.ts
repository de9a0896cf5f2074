// SPDX-License-Identifier: Apache-2.0
// The canvas. At most one picture is decoded and at most one waits, the newest. H.264 pictures are all decoded. A
// surface is lit here, and again when the light moves.
import type { Picture } from "../generated/fanlight_pb.js";
import { FilmDecoder } from "./film_decoder";
import type { SurfaceView } from "./surface/surface_view";

/** After the last movement of light or camera. */
const kRestMs = 150;
/** For so long a picture of another volume may still be on its way. */
const kOvertakenMs = 1500;
/** After the first surface. */
const kRehearseMs = 700;

export interface PictureViewEvents {
  shown(picture: Picture): void;
  /** Whether this display has turned the picture, where that has changed. */
  turned(turned: boolean): void;
  unreadable(sentence: string): void;
  /** This browser cannot show such pictures, or not quickly enough. */
  unsupported(): void;
}

export class PictureView {
  private decoding = false;
  private waiting: Picture | undefined;
  private held = false;
  private relightDue = false;
  private relitMs = -Infinity;
  private restTimer = 0;
  private expected: { volumeId: bigint; sinceMs: number } | undefined;
  private wasTurned = false;
  private rehearsed = false;
  private readonly context: CanvasRenderingContext2D;
  private readonly film: FilmDecoder;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly frame: HTMLElement,
    private readonly surface: SurfaceView,
    private readonly events: PictureViewEvents,
  ) {
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("This browser has no 2D canvas.");
    this.context = context;
    this.film = new FilmDecoder((frame, picture) => {
      if (this.held) return;
      this.draw(frame, frame.displayWidth, frame.displayHeight);
      this.events.shown(picture);
    }, events.unsupported);
  }

  /** Keeps the picture on this display as it is; a film is decoded on, since its next pictures depend on these. */
  hold(held: boolean): void {
    this.held = held;
    if (held) this.waiting = undefined;
  }

  show(picture: Picture): void {
    if (picture.h264.length > 0) {
      this.surface.forget();
      return this.film.decode(picture);
    }
    this.film.end();
    if (this.held) return;
    this.waiting = picture;
    if (!this.decoding) void this.decode();
  }

  /** The light or what it falls on may have changed: lights the surface again with the screen's next picture. */
  relight(): void {
    if (this.relightDue || this.held) return;
    this.relightDue = true;
    requestAnimationFrame(() => {
      this.relightDue = false;
      if (this.held || !this.surface.isOld) return;
      this.drawMoving();
    });
  }

  /** Coarsely where the browser is slow, and finely after a while at rest. */
  private drawMoving(): void {
    this.relitMs = performance.now();
    this.drawSurface(true);
    window.clearTimeout(this.restTimer);
    this.restTimer = window.setTimeout(() => this.refine(), kRestMs);
  }

  /** Light and camera have come to rest. */
  private refine(): void {
    if (!this.held && this.surface.isCoarse && !this.surface.isTurned) this.drawSurface(false);
  }

  private drawSurface(moving: boolean): void {
    this.surface.draw(this.context, moving);
    const { isTurned } = this.surface;
    if (isTurned !== this.wasTurned) this.events.turned(isTurned);
    this.wasTurned = isTurned;
    if (this.rehearsed || !this.surface.isShown) return;
    this.rehearsed = true;
    window.setTimeout(() => {
      this.surface.rehearse();
      if (this.surface.isTooSlow) this.events.unsupported();
    }, kRehearseMs);
  }

  /** Shows a volume that was shown before, until the server sends it again. Whether it can. */
  showKept(volumeId: bigint): boolean {
    if (this.held) return false;
    const picture = this.surface.showKept(volumeId);
    if (!picture) return false;
    this.expected = { volumeId, sinceMs: performance.now() };
    this.draw(undefined, picture.width, picture.height);
    this.drawMoving();
    this.events.shown(picture);
    return true;
  }

  /** Whether a picture was on its way before the volume that is shown since. */
  private isBefore(picture: Picture): boolean {
    const { expected } = this;
    if (!expected) return false;
    const isIt = picture.volumeId === expected.volumeId || performance.now() - expected.sinceMs > kOvertakenMs;
    if (isIt) this.expected = undefined;
    return !isIt;
  }

  private async decode(): Promise<void> {
    this.decoding = true;
    while (this.waiting) {
      const picture = this.waiting;
      this.waiting = undefined;
      if (picture.surface && !this.surface.works) {
        this.events.unsupported();
        continue;
      }
      try {
        const blob = blobOf(picture);
        const [bitmap] = await Promise.all([blob && createImageBitmap(blob), this.surface.unpack(picture)]);
        if (!this.held && !this.isBefore(picture)) {
          this.surface.show(picture);
          this.draw(bitmap, picture.width, picture.height);
          // A turned one is coarse until its cast is there: to draw it finely takes longer.
          this.drawSurface(performance.now() - this.relitMs < kRestMs || this.wasTurned);
          this.events.shown(picture);
        }
        bitmap?.close();
      } catch {
        this.events.unreadable(`Picture ${picture.pictureId} could not be decoded.`);
      }
    }
    this.decoding = false;
  }

  private draw(image: CanvasImageSource | undefined, width: number, height: number): void {
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.frame.style.setProperty("--aspect", String(width / height));
    }
    if (image) this.context.drawImage(image, 0, 0);
    this.frame.hidden = false;
  }
}

/** The pixels that the server has drawn; undefined where the surface is all that the picture shows. */
function blobOf(picture: Picture): Blob | undefined {
  if (picture.png.length > 0) return new Blob([picture.png], { type: "image/png" });
  if (picture.jpeg.length > 0) return new Blob([picture.jpeg], { type: "image/jpeg" });
  return undefined;
}
