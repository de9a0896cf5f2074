// The scene table, read from proto/scene.cpp and its defaults from proto/scene.hpp, so that it is not kept
// twice. What scene_for() gives a fan 16 cm deep is below.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

// A build tree has no proto/ where the sources have it.
const proto = process.env.FANLIGHT_PROTO ?? fileURLToPath(new URL("../../../proto", import.meta.url));
const source = readFileSync(join(proto, "scene.cpp"), "utf8");
const header = readFileSync(join(proto, "scene.hpp"), "utf8");

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

// row<MEMBER(member)>(name, unit, help, minimum, maximum, step, pass), choice<...>(name, help, pass, choices)
// or text_row<...>(name, help, pass)
const kRow = /(row|choice|text_row)<MEMBER\(([\w.]+)\)>\(((?:"[^"]*"|[^")])*)\)/g;
const rows = [...source.matchAll(kRow)].map(([, kind, member, list]) => {
  // Literals that follow one another on the next line are one.
  const joined = list.replace(/"\s*\n\s*"/g, "");
  const given = [...joined.matchAll(/"([^"]*)"|([^\s,]+)/g)].map(([, text, other]) => text ?? other);
  return { kind, member, given };
});
if (rows.length !== source.split("<MEMBER(").length - 1) throw new Error("a row of proto/scene.cpp was not understood");

export const fields = rows.map(({ kind, given }) => {
  const castsRays = given.some((argument) => /^FirstPass::k(Prepare|Cast)$/.test(argument));
  const number = { unit: "", minimum: 0, maximum: 0, step: 0, choices: [], isText: false, castsRays };
  if (kind === "text_row") return { ...number, name: given[0], help: given[1], isText: true };
  if (kind === "row") {
    const [name, unit, help, minimum, maximum, step] = given;
    return { ...number, name, unit, help, minimum: Number(minimum), maximum: Number(maximum), step: Number(step) };
  }
  const [name, help, , list] = given;
  const choices = strings(new RegExp(`${list}\\[\\] = \\{([^}]*)\\}`).exec(source)[1]);
  return { ...number, name, help, maximum: choices.length - 1, step: 1, choices };
});

const initial = members(header.slice(header.indexOf("struct Scene {"), header.indexOf("enum class FirstPass")));
export const defaults = Object.fromEntries(
  rows.map(({ member, given: [name] }, index) => [name, framed[name] ?? defaultOf(initial[member], fields[index])]),
);

/** "speckle.noise" -> "0.52", for members of the scene and of its structs. */
function members(text) {
  const found = {};
  let inside = {};
  for (const line of text.split("\n").slice(1)) {
    const end = /^ {2}\} ([\w, ]+);/.exec(line);
    const member = /^( +)[\w:]+ (\w+) = ([^;]+);/.exec(line);
    if (end) {
      for (const group of end[1].split(", ")) {
        for (const [name, value] of Object.entries(inside)) found[`${group}.${name}`] = value;
      }
      inside = {};
    } else if (member) {
      (member[1].length > 2 ? inside : found)[member[2]] = member[3];
    }
  }
  return found;
}

/** Of kDarkToBright that of dark-to-bright. */
function defaultOf(text, { name, choices }) {
  const words = /::k(\w+)$/.exec(text)?.[1].replace(/\B[A-Z]/g, "-$&").toLowerCase();
  const value = choices.length > 0 ? choices.indexOf(words) : Number(text);
  if (Number.isNaN(value) || (choices.length > 0 && value < 0)) throw new Error(`${name} has the default ${text}`);
  return value;
}

function strings(text) {
  return [...text.matchAll(/"([^"]*)"/g)].map(([, string]) => string);
}
