// SPDX-License-Identifier: Apache-2.0
// Draws a lit ball with bumps instead of the renderer's surface, and a disc instead of planes and volumes.
import jpeg from "jpeg-js";
import { fields } from "./fields.mjs";

const kSide = 320;
const modes = fields.find(({ name }) => name === "mode").choices;

/** Returns JPEG bytes. `values` is by dotted name; `turn_rad` moves the bumps from volume to volume. */
export function fakePicture(values, turn_rad) {
  const data = Buffer.alloc(kSide * kSide * 4, 12);
  const mode = modes[values.mode];
  const half = kSide / 2;
  if (mode === "slices") {
    const flat = disc([140, 140, 140]);
    paint(data, { left: 0, top: 0, width: half, height: half }, values, flat);
    paint(data, { left: half, top: 0, width: half, height: half }, values, flat);
    paint(data, { left: 0, top: half, width: half, height: half }, values, flat);
    paint(data, { left: half, top: half, width: half, height: half }, values, ballAt(values, turn_rad));
  } else if (mode === "surface-and-volume") {
    paint(data, { left: 0, top: 0, width: half, height: kSide }, values, ballAt(values, turn_rad));
    paint(data, { left: half, top: 0, width: half, height: kSide }, values, disc(volumeColour(values)));
  } else {
    const whole = { left: 0, top: 0, width: kSide, height: kSide };
    const grey = Array(3).fill(20 * values.mode);
    const flat = disc(mode === "volume" ? volumeColour(values) : grey);
    paint(data, whole, values, mode === "surface" ? ballAt(values, turn_rad) : flat);
  }
  return { jpeg: jpeg.encode({ data, width: kSide, height: kSide }, 85).data, width: kSide, height: kSide };
}

/** `colourAt(right, up, step)`, in mm, returns red, green and blue, or undefined for the background. */
function paint(data, part, values, colourAt) {
  const step_mm = values["camera.field_mm"] / part.height;
  for (let row = 0; row < part.height; ++row) {
    for (let column = 0; column < part.width; ++column) {
      const right = (column - part.width / 2 + 0.5) * step_mm;
      const up = (part.height / 2 - row - 0.5) * step_mm;
      const colour = colourAt(right, up, step_mm);
      if (colour) data.set([...colour, 255], ((part.top + row) * kSide + part.left + column) * 4);
    }
  }
}

function disc(colour) {
  return (right, up) => (Math.hypot(right, up) < 50 ? colour : undefined);
}

/** The transfer function's colour of the brightest echo, scaled by its opacity. */
function volumeColour(values) {
  const [, colour, opacity] = values["transfer.points"].split(",").at(-1).trim().split(/ +/);
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16) * Math.sqrt(opacity));
}

function ballAt(values, turn_rad) {
  const radius_mm = 60 - values["detector.threshold"] / 10;
  const yaw = values["camera.yaw_deg"] * (Math.PI / 180) + turn_rad;
  const pitch = values["camera.pitch_deg"] * (Math.PI / 180);
  const colour = ["red", "green", "blue"].map((part) => values[`light.${part}`] * values[`material.${part}`]);
  const depth_mm = (right, up) => {
    const square = radius_mm ** 2 - right ** 2 - up ** 2;
    if (square < 0) return NaN;
    const bump = Math.sin(right / 9 + 3 * yaw) * Math.sin(up / 9 + 3 * pitch) * (9 - values["filter.size"] / 4);
    return 80 - Math.sqrt(square) + bump * (square / radius_mm ** 2);
  };
  return (right, up, step_mm) => {
    const depth = depth_mm(right, up);
    if (Number.isNaN(depth)) return undefined;
    const normal = unit([
      (depth_mm(right + step_mm, up) - depth) / step_mm,
      (depth_mm(right, up + step_mm) - depth) / step_mm,
      -1,
    ]);
    const light = unit([
      values["light.right_mm"] - right,
      values["light.up_mm"] - up,
      values["light.depth_mm"] - depth,
    ]);
    const cosine = Math.max(0, normal[0] * light[0] + normal[1] * light[1] + normal[2] * light[2]);
    const matt = values["light.ambient"] + values["light.diffuse"] * cosine;
    const shiny = values["light.specular"] * cosine ** values["light.shininess"];
    return colour.map((part) => Math.min(255, 255 * (part * matt + shiny)));
  };
}

function unit(vector) {
  const length = Math.hypot(...vector);
  return vector.map((component) => component / length);
}
