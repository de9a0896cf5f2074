// A lit ball with bumps, in the place of the renderer.
import jpeg from "jpeg-js";

const kSide = 320;

/** JPEG bytes. `values` by dotted name; `turn_rad` moves the bumps from volume to volume. */
export function fakePicture(values, turn_rad) {
  const field_mm = values["camera.field_mm"];
  const radius_mm = 60 - values["detector.threshold"] / 10;
  const yaw = values["camera.yaw_deg"] * (Math.PI / 180) + turn_rad;
  const pitch = values["camera.pitch_deg"] * (Math.PI / 180);
  const depth_mm = (right, up) => {
    const square = radius_mm ** 2 - right ** 2 - up ** 2;
    if (square < 0) return NaN;
    const bump = Math.sin(right / 9 + 3 * yaw) * Math.sin(up / 9 + 3 * pitch) * (9 - values["filter.size"] / 4);
    return 80 - Math.sqrt(square) + bump * (square / radius_mm ** 2);
  };

  const data = Buffer.alloc(kSide * kSide * 4, 12);
  const step_mm = field_mm / kSide;
  for (let row = 0; row < kSide; ++row) {
    for (let column = 0; column < kSide; ++column) {
      const right = (column - kSide / 2 + 0.5) * step_mm;
      const up = (kSide / 2 - row - 0.5) * step_mm;
      const depth = depth_mm(right, up);
      if (Number.isNaN(depth)) continue;
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
      const shade =
        values["light.ambient"] +
        values["light.diffuse"] * cosine +
        values["light.specular"] * cosine ** values["light.shininess"];
      data.set(
        [Math.min(255, 250 * shade), Math.min(255, 190 * shade), Math.min(255, 140 * shade), 255],
        (row * kSide + column) * 4,
      );
    }
  }
  return { jpeg: jpeg.encode({ data, width: kSide, height: kSide }, 85).data, width: kSide, height: kSide };
}

function unit(vector) {
  const length = Math.hypot(...vector);
  return vector.map((component) => component / length);
}
