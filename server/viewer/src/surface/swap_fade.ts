// SPDX-License-Identifier: Apache-2.0
// Fades from the picture on show to one that the server has cast since, where both show the same surface. Where they do
// not, the new one is there at once: two shapes are never seen through each other.

const kFadeMs = 100;

export class SwapFade {
  private readonly before = document.createElement("canvas");
  private readonly after = document.createElement("canvas");
  private frame = 0; // 0: it does not run

  constructor(private readonly canvas: HTMLCanvasElement) {}

  /** Keeps the picture on show. */
  keep(): void {
    copy(this.canvas, this.before);
  }

  /** Fades from the kept picture to the one on show. `agrees`: width x height, 255 where both show the same, else 0. */
  run(agrees: Uint8ClampedArray, width: number, height: number): void {
    const mask = new ImageData(width, height);
    for (const [index, value] of agrees.entries()) mask.data[4 * index + 3] = value;
    const masked = document.createElement("canvas");
    Object.assign(masked, { width, height });
    masked.getContext("2d")!.putImageData(mask, 0, 0);
    const context = this.before.getContext("2d")!;
    context.globalCompositeOperation = "destination-in";
    context.drawImage(masked, 0, 0, this.before.width, this.before.height);
    context.globalCompositeOperation = "source-over";
    copy(this.canvas, this.after);
    const beganMs = performance.now();
    const step = () => {
      const left = 1 - (performance.now() - beganMs) / kFadeMs;
      this.draw(Math.max(0, left));
      this.frame = left > 0 ? requestAnimationFrame(step) : 0;
    };
    step();
  }

  /** Something else is drawn now. */
  end(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
  }

  private draw(left: number): void {
    const { width, height } = this.canvas;
    const context = this.canvas.getContext("2d")!;
    context.drawImage(this.after, 0, 0, width, height);
    context.globalAlpha = left;
    context.drawImage(this.before, 0, 0, width, height);
    context.globalAlpha = 1;
  }
}

function copy(from: HTMLCanvasElement, to: HTMLCanvasElement): void {
  [to.width, to.height] = [from.width, from.height]; // clears it too
  to.getContext("2d")!.drawImage(from, 0, 0);
}
