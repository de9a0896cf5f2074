// SPDX-License-Identifier: Apache-2.0
// Records what this display shows as JPEG pictures, as an archive takes them.

export const kClipS = 5;
export const kPerSecond = 10;
const kMostPictures = kClipS * kPerSecond;
// One request has 16 MB, in base64.
const kMostPixels = 800_000;
const kMostBytes = 11_500_000;
const kQuality = 0.9;

/**
 * Pictures at a fixed rate, for kClipS from the first one on, or shorter where they become too large. `next`: the picture
 * with its marks; undefined while there is none. Where the next one is late, the last one is repeated. `left`: told how
 * many seconds are left.
 */
export async function recordClip(
  next: () => Promise<HTMLCanvasElement> | undefined,
  left: (seconds: number) => void,
): Promise<Blob[]> {
  const jpegs: Blob[] = [];
  const clip = document.createElement("canvas");
  const askedMs = performance.now();
  let begunMs: number | undefined;
  let last: Blob | undefined;
  let bytes = 0;
  while (jpegs.length < kMostPictures) {
    const takenMs = performance.now();
    const picture = await next();
    if (picture) {
      last = await jpegOf(picture, clip);
      begunMs ??= takenMs;
    }
    if (last === undefined && takenMs - askedMs > 1000 * kClipS) throw new Error("there was no picture");
    const elapsedS = begunMs === undefined ? 0 : (takenMs - begunMs) / 1000;
    const due = Math.min(kMostPictures, Math.floor(elapsedS * kPerSecond) + 1);
    for (; last && jpegs.length < due; bytes += last.size) {
      if (bytes + last.size > kMostBytes) return jpegs;
      jpegs.push(last);
    }
    left(Math.ceil(Math.max(0, kClipS - elapsedS)));
    await new Promise((resolve) => setTimeout(resolve, Math.max(0, takenMs + 1000 / kPerSecond - performance.now())));
  }
  return jpegs;
}

/** In the size of the first one: a clip has one size, and the display's may change. */
async function jpegOf(picture: HTMLCanvasElement, clip: HTMLCanvasElement): Promise<Blob> {
  if (!clip.dataset.isSized) {
    const scale = Math.min(1, Math.sqrt(kMostPixels / (picture.width * picture.height)));
    // Archives that pack colours by pairs want even numbers.
    [clip.width, clip.height] = [picture.width, picture.height].map((side) => 2 * Math.round((side * scale) / 2)) as [
      number,
      number,
    ];
    clip.dataset.isSized = "yes";
  }
  const context = clip.getContext("2d")!;
  context.fillRect(0, 0, clip.width, clip.height);
  context.imageSmoothingQuality = "high";
  const scale = Math.min(clip.width / picture.width, clip.height / picture.height);
  const [width, height] = [picture.width * scale, picture.height * scale];
  context.drawImage(picture, (clip.width - width) / 2, (clip.height - height) / 2, width, height);
  const blob = await new Promise<Blob | null>((resolve) => clip.toBlob(resolve, "image/jpeg", kQuality));
  if (!blob) throw new Error("the browser cannot write this picture");
  return blob;
}
