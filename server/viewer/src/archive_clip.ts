// SPDX-License-Identifier: Apache-2.0
// Records what this display shows as JPEG pictures, as an archive takes them.

export const kClipS = 5;
const kPerSecond = 10;
const kMostHeight = 1024; // so that a clip fits into one request
const kQuality = 0.9;

export interface RecordedClip {
  jpegs: Blob[];
  perSecond: number;
}

/**
 * Takes a picture ten times a second, for kClipS. `next`: the picture with its marks; undefined while there is none, and
 * the last one stays. `left`: told how many seconds are left.
 */
export async function recordClip(
  next: () => Promise<HTMLCanvasElement> | undefined,
  left: (seconds: number) => void,
): Promise<RecordedClip> {
  const jpegs: Blob[] = [];
  const clip = document.createElement("canvas");
  const begunMs = performance.now();
  let takenMs = begunMs;
  for (let elapsedS = 0; elapsedS < kClipS; elapsedS = (takenMs - begunMs) / 1000) {
    left(Math.ceil(kClipS - elapsedS));
    const picture = await next();
    if (picture) jpegs.push(await jpegOf(picture, clip));
    else if (jpegs.length > 0) jpegs.push(jpegs.at(-1)!);
    await pause(Math.max(0, takenMs + 1000 / kPerSecond - performance.now()));
    takenMs = performance.now();
  }
  if (jpegs.length === 0) throw new Error("there was no picture");
  return { jpegs, perSecond: jpegs.length / ((takenMs - begunMs) / 1000) };
}

/** In the size of the first one: a clip has one size, and the server's may change. */
async function jpegOf(picture: HTMLCanvasElement, clip: HTMLCanvasElement): Promise<Blob> {
  const context = clip.getContext("2d")!;
  if (!clip.dataset.isSized) {
    const scale = Math.min(1, kMostHeight / picture.height);
    [clip.width, clip.height] = [Math.round(picture.width * scale), Math.round(picture.height * scale)];
    clip.dataset.isSized = "yes";
  }
  context.imageSmoothingQuality = "high";
  context.drawImage(picture, 0, 0, clip.width, clip.height);
  const blob = await new Promise<Blob | null>((resolve) => clip.toBlob(resolve, "image/jpeg", kQuality));
  if (!blob) throw new Error("the browser cannot write this picture");
  return blob;
}

function pause(ms: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, ms));
}
