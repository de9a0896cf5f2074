// SPDX-License-Identifier: Apache-2.0
// The scene table as `fanlight info --fields --json` prints it. Read from the recorded copy, because the page is built
// before the program; the test cli/contract compares the two. `framed` is what scene_for() sets for a fan 16 cm deep.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

// In a build tree, tests/ is not next to the sources; then FANLIGHT_TESTS names it.
const tests = process.env.FANLIGHT_TESTS ?? fileURLToPath(new URL("../../../tests", import.meta.url));
const rows = JSON.parse(readFileSync(join(tests, "cli/contract/scene_fields.json"), "utf8"));

const framed = {
  "camera.target_x_mm": 0,
  "camera.target_y_mm": 80,
  "camera.target_z_mm": 0,
  "camera.distance_mm": 80,
  "camera.field_mm": 163.84,
  "rays.end_mm": 160,
  "slice.depth_mm": 80,
  "light.right_mm": -68.81,
  "light.up_mm": 68.81,
  "light.depth_mm": -65.54,
  "transfer.points": "0 #591f14 0, 60 #804f41 0, 255 #ffebd1 0.3",
};

export const fields = rows.map((row) => ({
  name: row.name,
  help: row.help,
  unit: row.unit ?? "",
  minimum: row.minimum ?? 0,
  maximum: row.choices ? row.choices.length - 1 : (row.maximum ?? 0),
  step: row.choices ? 1 : (row.step ?? 0),
  choices: row.choices ?? [],
  isText: row.kind === "text",
  castsRays: row.first_pass === "prepare" || row.first_pass === "cast",
}));

export const defaults = Object.fromEntries(
  rows.map((row) => {
    const value = row.kind === "choice" ? row.choices.indexOf(row.default) : row.default;
    return [row.name, framed[row.name] ?? value];
  }),
);
