const signs = ["dark-to-bright", "bright-to-dark", "either"];

// The fields of proto/scene.cpp, with the defaults that scene_for() gives a fan 16 cm deep:
// [name, unit, help, minimum, maximum, step, default, casts rays, choices]
const rows = [
  ["camera.target_x_mm", "mm", "point that the orbit keeps in the middle, lateral", -1000, 1000, 0, 0, true],
  ["camera.target_y_mm", "mm", "the same, below the probe face", -1000, 1000, 0, 80, true],
  ["camera.target_z_mm", "mm", "the same, elevation", -1000, 1000, 0, 0, true],
  ["camera.yaw_deg", "deg", "orbit about elevation, positive towards the marked side", -180, 180, 0, 0, true],
  ["camera.pitch_deg", "deg", "orbit upwards", -90, 90, 0, 0, true],
  ["camera.roll_deg", "deg", "turn of the camera about its view direction, clockwise", -180, 180, 0, 0, true],
  ["camera.distance_mm", "mm", "from the view plane to the target", 0, 2000, 0, 80, true],
  ["camera.field_mm", "mm", "height of the picture in the body", 1, 2000, 0, 163.84, true],
  ["rays.start_mm", "mm", "depth below the view plane at which rays start", 0, 2000, 0, 0, true],
  ["rays.end_mm", "mm", "depth at which they end", 0, 3000, 0, 160, true],
  ["rays.step_mm", "mm", "distance of samples; 0 takes the finer pixel size of the frame", 0, 10, 0, 0, true],
  ["detector.threshold", "grey levels", "step in the echo that makes a surface", 0, 255, 0, 40, true],
  ["detector.window", "samples", "samples that the edge detector compares, even", 2, 32, 2, 8, true],
  ["detector.sign", "", "which way the echo must step", 0, 2, 1, 0, true, signs],
  ["transfer.transparent", "grey levels", "volume mode: nothing is seen up to here", 0, 255, 0, 60, true],
  ["transfer.opaque", "grey levels", "volume mode: full opacity from here", 0, 255, 0, 255, true],
  ["transfer.opacity_per_mm", "per mm", "volume mode: share of light stopped by a millimetre", 0, 0.999, 0, 0.3, true],
  ["filter.size", "pixels", "side of the moving average over the depth map, odd", 1, 31, 2, 7, false],
  ["light.right_mm", "mm", "point light, right of the picture's centre", -2000, 2000, 0, -65.54, false],
  ["light.up_mm", "mm", "point light, above the picture's centre", -2000, 2000, 0, 65.54, false],
  ["light.depth_mm", "mm", "point light, beyond the view plane (negative: before it)", -2000, 2000, 0, -40.96, false],
  ["light.ambient", "", "light from everywhere", 0, 1, 0, 0.15, false],
  ["light.diffuse", "", "matt reflection", 0, 1, 0, 0.75, false],
  ["light.specular", "", "shiny reflection", 0, 1, 0, 0.25, false],
  ["light.shininess", "", "exponent of the shiny reflection", 1, 256, 0, 24, false],
  ["shadow.coefficient", "", "brightness left in a shadow; 1 casts none", 0, 1, 0, 0.45, false],
  ["mode", "", "what the picture shows", 0, 1, 1, 0, true, ["surface", "volume"]],
  ["finish", "", "smoothing of the picture: none, or a 2 x 2 mean", 0, 1, 1, 1, false, ["none", "mean"]],
];

export const fields = rows.map(([name, unit, help, minimum, maximum, step, , castsRays, choices = []]) => ({
  name,
  unit,
  help,
  minimum,
  maximum,
  step,
  choices,
  castsRays,
}));

export const defaults = Object.fromEntries(rows.map(([name, , , , , , value]) => [name, value]));
