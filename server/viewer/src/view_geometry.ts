// SPDX-License-Identifier: Apache-2.0
// Converts between pixels of the picture and the view frame of the scene (proto/model/scene.hpp): mm to the right of
// and above its centre. Pixels count from the upper left corner of the picture and may be fractional.

export interface Size {
  width: number;
  height: number;
}
export interface Rectangle extends Size {
  left: number;
  top: number;
  /** How many pixels the field covers; absent: the height. */
  fieldPixels?: number;
}
export interface PagePoint {
  x: number;
  y: number;
}
export interface ViewPoint {
  rightMm: number;
  upMm: number;
}

/** The camera parameters that set the scale of a depth in the picture. */
export interface Lens {
  fieldMm: number;
  distanceMm: number;
  perspective: boolean;
  openingDeg: number;
}

const kOrbitDegPerHeight = 180;
const kLeastScale = 0.1;

/** The part of a picture that shows the surface (as viewport() in renderer/parameters); undefined for planes alone. */
export function surfacePart(mode: string, { width, height }: Size): Rectangle | undefined {
  const halfWidth = Math.floor(width / 2);
  const halfHeight = Math.floor(height / 2);
  switch (mode) {
    case "slice":
    case "tomography":
      return undefined;
    case "slices":
      return { left: halfWidth, top: halfHeight, width: width - halfWidth, height: height - halfHeight };
    case "surface-and-volume":
      // In this mode camera.field_mm covers the smaller side.
      return { left: 0, top: 0, width: halfWidth, height, fieldPixels: Math.min(halfWidth, height) };
    default:
      return { left: 0, top: 0, width, height };
  }
}

/**
 * Millimetres at this depth that cover as many pixels as one millimetre at the depth of the target; 1 without
 * perspective. A point behind the eye or close to it has no pixel, but the marker of a light needs one: it is drawn as
 * if it were as far in front of the eye, or at a small distance from it.
 */
export function scaleAt(depthMm: number, lens: Lens): number {
  if (!lens.perspective) return 1;
  const eyeToTargetMm = lens.fieldMm / (2 * Math.tan((lens.openingDeg * Math.PI) / 360));
  const eyeToPlaneMm = eyeToTargetMm - lens.distanceMm;
  return Math.max(kLeastScale, Math.abs(depthMm + eyeToPlaneMm) / eyeToTargetMm);
}

/** The pixel of the picture under a point of the page. */
export function picturePixel(pointer: PagePoint, canvas: HTMLCanvasElement): PagePoint {
  const shown = canvas.getBoundingClientRect();
  return {
    x: ((pointer.x - shown.left) * canvas.width) / shown.width,
    y: ((pointer.y - shown.top) * canvas.height) / shown.height,
  };
}

/** The inverse of picturePixel(). */
export function pagePoint(pixel: PagePoint, canvas: HTMLCanvasElement): PagePoint {
  const shown = canvas.getBoundingClientRect();
  return {
    x: shown.left + (pixel.x * shown.width) / canvas.width,
    y: shown.top + (pixel.y * shown.height) / canvas.height,
  };
}

/** `part` shows the surface; `fieldMm` is the height that it covers at the depth in question. */
export function viewPoint(pixel: PagePoint, part: Rectangle, fieldMm: number): ViewPoint {
  const mmPerPixel = fieldMm / (part.fieldPixels ?? part.height);
  return {
    rightMm: tidy((pixel.x - part.left - part.width / 2) * mmPerPixel),
    upMm: tidy((part.top + part.height / 2 - pixel.y) * mmPerPixel),
  };
}

/** The inverse of viewPoint(). */
export function pixelOf(point: ViewPoint, part: Rectangle, fieldMm: number): PagePoint {
  const pixelsPerMm = (part.fieldPixels ?? part.height) / fieldMm;
  return {
    x: part.left + part.width / 2 + point.rightMm * pixelsPerMm,
    y: part.top + part.height / 2 - point.upMm * pixelsPerMm,
  };
}

/** The body follows the pointer: a drag to the right moves the camera to the left. */
export function orbited(
  angles: { yawDeg: number; pitchDeg: number },
  moved: PagePoint,
  viewHeight: number,
): { yawDeg: number; pitchDeg: number } {
  const degPerPixel = kOrbitDegPerHeight / viewHeight;
  const yaw = angles.yawDeg - moved.x * degPerPixel;
  const pitch = angles.pitchDeg + moved.y * degPerPixel;
  return {
    yawDeg: tidy(yaw - 360 * Math.round(yaw / 360)),
    pitchDeg: tidy(Math.min(90, Math.max(-90, pitch))),
  };
}

/** How the camera is turned, degrees. */
export interface Turn {
  yawDeg: number;
  pitchDeg: number;
  rollDeg: number;
}

/**
 * The way in the transducer frame, mm, of a way to the right, up and forward in the view; the directions are those of
 * view_frame() in renderer/parameters.
 */
export function bodyWay(turn: Turn, right: number, up: number, forward: number): { x: number; y: number; z: number } {
  const [yaw, pitch, roll] = [turn.yawDeg, turn.pitchDeg, turn.rollDeg].map((deg) => (deg * Math.PI) / 180);
  const level = Math.cos(roll!) * right + Math.sin(roll!) * up;
  const upright = Math.cos(roll!) * up - Math.sin(roll!) * right;
  const deep = Math.cos(pitch!) * forward + Math.sin(pitch!) * upright; // in the plane of x and y
  return {
    x: Math.cos(yaw!) * level - Math.sin(yaw!) * deep,
    y: Math.sin(yaw!) * level + Math.cos(yaw!) * deep,
    z: -Math.sin(pitch!) * forward + Math.cos(pitch!) * upright,
  };
}

/** Two decimals: finer than a hand can aim, and readable in a number box. */
export function tidy(value: number): number {
  return Math.round(value * 100) / 100;
}
