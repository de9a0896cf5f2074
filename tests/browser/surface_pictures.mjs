// SPDX-License-Identifier: Apache-2.0
// The pictures of a page, as numbers. The functions run in the page, and use nothing from here.

/** Runs in the page: how its picture differs from the server's picture of the same scene, in the part given. */
export async function differences(part) {
  const pixelsOf = (image, width, height) => {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { width, height });
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    return context.getImageData(part.left * width, part.top * height, width, height).data;
  };
  const shown = document.querySelector("#picture");
  const bitmap = await createImageBitmap(await (await fetch("/api/picture.png")).blob());
  const [a, b] = [shown, bitmap].map((image) => pixelsOf(image, bitmap.width, bitmap.height));
  let [sum, most, count, light] = [0, 0, 0, 0];
  for (let at = 0; at < a.length; ++at) {
    if (at % 4 === 3 || a[4 * (at >> 2) + 3] === 0) continue; // beyond the canvas
    const apart = Math.abs(a[at] - b[at]);
    sum += apart;
    light += b[at];
    most = Math.max(most, apart);
    ++count;
  }
  return { mean: sum / count, most, light: light / count, width: shown.width };
}

/** Runs in the page: grey levels of the picture with 40 pixels on each side. */
export function thumbnail() {
  const side = 40;
  const context = new OffscreenCanvas(side, side).getContext("2d");
  context.imageSmoothingQuality = "high";
  context.drawImage(document.querySelector("#picture"), 0, 0, side, side);
  const { data } = context.getImageData(0, 0, side, side);
  return Array.from({ length: side * side }, (_, pixel) => data[4 * pixel + 1]);
}
