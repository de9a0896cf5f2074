// Between pixels of the page and the view frame of the scene: right and up of the picture's centre in mm,
// fieldMm being the picture's height in the body. Rectangles and points are in CSS pixels.

export interface Rectangle {
  left: number;
  top: number;
  width: number;
  height: number;
}
export interface PagePoint {
  x: number;
  y: number;
}
export interface ViewPoint {
  rightMm: number;
  upMm: number;
}

const kOrbitDegPerHeight = 180;

export function viewPoint(point: PagePoint, picture: Rectangle, fieldMm: number): ViewPoint {
  const mmPerPixel = fieldMm / picture.height;
  return {
    rightMm: tidy((point.x - picture.left - picture.width / 2) * mmPerPixel),
    upMm: tidy((picture.top + picture.height / 2 - point.y) * mmPerPixel),
  };
}

/** As fractions of the picture's width and height from its top left corner; `aspect` is width / height. */
export function pictureFraction(point: ViewPoint, aspect: number, fieldMm: number): PagePoint {
  return { x: 0.5 + point.rightMm / (fieldMm * aspect), y: 0.5 - point.upMm / fieldMm };
}

/** The body follows the pointer: dragged to the right, the camera goes to the left. */
export function orbited(
  angles: { yawDeg: number; pitchDeg: number },
  moved: PagePoint,
  pictureHeight: number,
): { yawDeg: number; pitchDeg: number } {
  const degPerPixel = kOrbitDegPerHeight / pictureHeight;
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
