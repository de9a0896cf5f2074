// SPDX-License-Identifier: Apache-2.0
// The canvas. At most one picture is decoded and at most one waits, the newest. H.264 pictures are all decoded. A
// surface is lit here, and again when the light moves.
import type { Picture } from "../generated/fanlight_pb.js";
import { FilmDecoder } from "./film_decoder";
import type { SurfaceView } from "./surface/surface_view";
import { SwapFade } from "./surface/swap_fade";

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
  /** This display has drawn the surface again, maybe from another view. */
  drawn(): void;
  unreadable(sentence: string): void;
  /** This browser cannot show such pictures. */
  unsupported(): void;
  /** It lights no surfaces now: WebGL is missing, was lost, or is too slow. */
  noSurfaces(): void;
  /** The server has to send the picture again, whole. */
  missing(): void;
}

export class PictureView {
  private decoding = false;
  private waiting: Picture | undefined;
  private held = false;
  private relightDue = false;
  private relitMs = -Infinity;
  private restTimer = 0;
  private expected: bigint | undefined; // the volume that this display shows before the server does
  private expectedTimer = 0;
  private filming = false; // the last picture was of a film
  private liveSinceMs = -Infinity;
  private shownId = 0n; // of the volume on show
  private looping = false; // this display shows volumes that it has kept, not what the server sends
  private wasTurned = false;
  private rehearsed = false;
  private readonly fade: SwapFade;
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
    this.fade = new SwapFade(canvas);
    this.film = new FilmDecoder((frame, picture) => {
      if (this.held || this.isBefore(picture)) return;
      this.shownId = picture.volumeId;
      this.draw(frame, frame.displayWidth, frame.displayHeight);
      this.events.shown(picture);
    }, events.unsupported);
  }

  /** Keeps the picture on this display as it is; a film is decoded on, since its next pictures depend on these. */
  hold(held: boolean): void {
    if (this.held && !held) this.events.missing(); // what came meanwhile may not come again
    this.held = held;
    if (held) this.waiting = undefined;
  }

  show(picture: Picture): void {
    this.filming = picture.h264.length > 0;
    if (this.filming) {
      this.looping = false;
      this.surface.forget();
      this.noteTurned();
      return this.film.decode(picture);
    }
    this.film.end();
    if (this.held) return;
    // The server sends a surface once: the next picture takes over that of a skipped one.
    const skipped = this.waiting?.surface;
    if (skipped && skipped.surfaceId === picture.surface?.surfaceId && picture.surface.runs.length === 0)
      picture.surface = skipped;
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
    this.fade.end();
    try {
      this.surface.draw(this.context, moving);
    } catch {
      return this.noSurfaces(); // a shader that this browser does not compile
    }
    this.noteTurned();
    this.events.drawn();
    if (this.rehearsed && this.surface.isTooSlow) return this.noSurfaces();
    if (this.rehearsed || !this.surface.isShown) return;
    this.rehearsed = true;
    window.setTimeout(() => this.rehearse(), kRehearseMs);
  }

  private noteTurned(): void {
    const { isTurned } = this.surface;
    if (isTurned !== this.wasTurned) this.events.turned(isTurned);
    this.wasTurned = isTurned;
  }

  private rehearse(): void {
    try {
      this.surface.rehearse();
    } catch {
      return this.noSurfaces();
    }
    if (this.surface.isTooSlow) this.noSurfaces();
  }

  private noSurfaces(): void {
    this.surface.forgetPace();
    this.rehearsed = false; // the next surface is judged again
    this.events.noSurfaces();
  }

  /** Shows a volume that was shown before, until the server sends it again. Whether it can. */
  showKept(volumeId: bigint): boolean {
    if (this.held) return false;
    const picture = this.surface.showKept(volumeId);
    this.expectNothing();
    if (!picture) return false;
    this.stayAt(volumeId);
    this.shownId = volumeId;
    this.draw(undefined, picture.width, picture.height);
    this.drawMoving();
    this.events.shown(picture);
    return true;
  }

  /** Drops what the server sends of other volumes until it sends this one, for a while. */
  stayAt(volumeId: bigint): void {
    if (this.held || volumeId === 0n) return;
    window.clearTimeout(this.expectedTimer);
    this.expected = volumeId;
    this.expectedTimer = window.setTimeout(() => this.giveUpExpected(), kOvertakenMs);
  }

  /** Shows a volume that was shown before, and none that the server sends until endLoop(). Whether it can. */
  loop(volumeId: bigint): boolean {
    const picture = this.held || this.filming ? undefined : this.surface.showKept(volumeId);
    this.looping = picture !== undefined;
    if (!picture) return false;
    this.shownId = volumeId;
    this.draw(undefined, picture.width, picture.height);
    this.drawMoving();
    this.events.shown(picture);
    return true;
  }

  endLoop(): void {
    this.looping = false;
  }

  /** The server has ended the loop at this volume, which it may have sent during the loop; 0: at a new one. */
  endLoopAt(volumeId: bigint): void {
    this.looping = false;
    if (!this.showKept(volumeId)) this.events.missing();
    this.expected = undefined;
  }

  /** Whether new volumes are shown, which has changed. What was asked for before counts no more. */
  setLive(live: boolean): void {
    this.liveSinceMs = live ? performance.now() : -Infinity;
    if (live) this.expectNothing();
  }

  /** The server has frozen this volume: another one than this display has asked for is not waited for. */
  frozenAt(volumeId: bigint): void {
    if (this.expected !== volumeId) this.giveUpExpected();
  }

  /** Of the volume on show; 0: none. */
  get volumeId(): bigint {
    return this.shownId;
  }

  private expectNothing(): void {
    this.expected = undefined;
    window.clearTimeout(this.expectedTimer);
  }

  /** Call at the start of a session. */
  start(): void {
    this.looping = false;
    this.liveSinceMs = -Infinity;
    this.shownId = 0n;
    this.expectNothing();
    this.surface.forgetAll();
  }

  /** The server shows something else than this display has asked for, which may have been skipped here. */
  private giveUpExpected(): void {
    if (this.expected === undefined) return;
    this.expectNothing();
    this.events.missing();
  }

  /** Whether a picture was on its way before the volume that is shown since. */
  private isBefore({ volumeId }: Picture): boolean {
    const wasJustFrozen = performance.now() - this.liveSinceMs < kOvertakenMs;
    if (this.expected === undefined) return wasJustFrozen && volumeId < this.shownId;
    if (this.expected !== volumeId) return true;
    this.expected = undefined;
    return false;
  }

  private async decode(): Promise<void> {
    this.decoding = true;
    while (this.waiting) {
      const picture = this.waiting;
      this.waiting = undefined;
      if (picture.surface && !this.surface.works) {
        this.noSurfaces();
        continue;
      }
      try {
        const blob = blobOf(picture);
        const [bitmap, isWhole] = await Promise.all([
          blob && createImageBitmap(blob),
          picture.surface ? this.unpack(picture) : true,
        ]);
        if (isWhole && !this.held && !this.looping && !this.isBefore(picture)) {
          this.shownId = picture.volumeId;
          const before = this.surface.depthsBefore(picture);
          if (before) this.fade.keep();
          this.surface.show(picture);
          this.draw(bitmap, picture.width, picture.height);
          // A turned one is coarse until its cast is there: to draw it finely takes longer.
          this.drawSurface(performance.now() - this.relitMs < kRestMs || this.surface.isToTurn);
          const same = this.surface.agreesWith(before);
          if (same && !this.surface.isTurned) this.fade.run(same.mask, same.grid.width, same.grid.height);
          this.events.shown(picture);
        }
        bitmap?.close();
      } catch {
        this.events.unreadable(`Picture ${picture.pictureId} could not be decoded.`);
      }
    }
    this.decoding = false;
  }

  /** Whether the surface of the picture is there. */
  private async unpack(picture: Picture): Promise<boolean> {
    try {
      if (await this.surface.unpack(picture)) return true;
      this.events.missing();
    } catch {
      this.events.unsupported();
    }
    return false;
  }

  private draw(image: CanvasImageSource | undefined, width: number, height: number): void {
    this.fade.end();
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
