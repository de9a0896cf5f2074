// Between pixels of the picture and the view frame of the scene (proto/scene.hpp): right and up of its
// centre in mm. A picture's pixels are counted from its upper left corner, in fractions too.

export interface Size {
  width: number;
  height: number;
}
export interface Rectangle extends Size {
  left: number;
  top: number;
  /** How many pixels the field covers, where that is not the height. */
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

/** What makes a depth's millimetres larger or smaller in the picture. */
export interface Lens {
  fieldMm: number;
  distanceMm: number;
  perspective: boolean;
  openingDeg: number;
}

const kOrbitDegPerHeight = 180;
const kLeastScale = 0.1;

/** The part of a picture that shows the surface, as in renderer/view.hpp; none in the mode that casts no rays. */
export function surfacePart(mode: string, { width, height }: Size): Rectangle | undefined {
  const halfWidth = Math.floor(width / 2);
  const halfHeight = Math.floor(height / 2);
  switch (mode) {
    case "slice":
      return undefined;
    case "slices":
      return { left: halfWidth, top: halfHeight, width: width - halfWidth, height: height - halfHeight };
    case "surface-and-volume":
      // Narrow: the field is the smaller side.
      return { left: 0, top: 0, width: halfWidth, height, fieldPixels: Math.min(halfWidth, height) };
    default:
      return { left: 0, top: 0, width, height };
  }
}

/**
 * How many millimetres of this depth cover what one at the target's depth does: 1 without perspective.
 * Nothing behind the eye or close to it has a place in the picture; a lamp there must have one all the same,
 * so it is shown where it would stand as far before the eye, or a little away from it.
 */
export function scaleAt(depthMm: number, lens: Lens): number {
  if (!lens.perspective) return 1;
  const eyeToTargetMm = lens.fieldMm / (2 * Math.tan((lens.openingDeg * Math.PI) / 360));
  const eyeToPlaneMm = eyeToTargetMm - lens.distanceMm;
  return Math.max(kLeastScale, Math.abs(depthMm + eyeToPlaneMm) / eyeToTargetMm);
}

/** `part` shows the surface, `fieldMm` is what its height covers at the depth that is meant. */
export function viewPoint(pixel: PagePoint, part: Rectangle, fieldMm: number): ViewPoint {
  const mmPerPixel = fieldMm / (part.fieldPixels ?? part.height);
  return {
    rightMm: tidy((pixel.x - part.left - part.width / 2) * mmPerPixel),
    upMm: tidy((part.top + part.height / 2 - pixel.y) * mmPerPixel),
  };
}

/** The way back. */
export function pixelOf(point: ViewPoint, part: Rectangle, fieldMm: number): PagePoint {
  const pixelsPerMm = (part.fieldPixels ?? part.height) / fieldMm;
  return {
    x: part.left + part.width / 2 + point.rightMm * pixelsPerMm,
    y: part.top + part.height / 2 - point.upMm * pixelsPerMm,
  };
}

/** The body follows the pointer: dragged to the right, the camera goes to the left. */
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

/** Two decimals: finer than anybody's hand, and readable in a number box. */
export function tidy(value: number): number {
  return Math.round(value * 100) / 100;
}
