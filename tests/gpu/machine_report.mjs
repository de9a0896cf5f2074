// SPDX-License-Identifier: Apache-2.0
// Writes the report of tests/gpu/machine from the JSON that the commands of bench printed.
//   node machine_report.mjs FIGURES OUTPUT
import { readFileSync, readdirSync, existsSync, writeFileSync } from "node:fs";
import { execFileSync } from "node:child_process";
import { cpus } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const [figures, output] = process.argv.slice(2);
const project = join(dirname(fileURLToPath(import.meta.url)), "../..");
const read = (name) => JSON.parse(readFileSync(join(figures, name), "utf8"));
const given = (name) => (existsSync(join(figures, `${name}.json`)) ? read(`${name}.json`) : undefined);
const line = (...command) => {
  try {
    return execFileSync(command[0], command.slice(1), { cwd: project, encoding: "utf8" }).trim();
  } catch {
    return "unknown";
  }
};

const reports = readdirSync(figures)
  .filter((name) => name.startsWith("row-"))
  .map(read);
const rows = Object.fromEntries(reports.flatMap(({ rows }) => rows.map((row) => [row.name, row])));
const { device, kind, driver } = reports[0];
const pipeline = given("pipeline");
const rate = given("rate");
const memory = given("memory");

const digits = (value) =>
  value === undefined ? "-" : value >= 100 ? value.toFixed(0) : value.toPrecision(value < 1 ? 2 : 3);
const p50 = (row, stage) => rows[row]?.stages_ms[stage]?.p50;
const table = (head, lines) =>
  [head, head.map(() => "---"), ...lines].map((cells) => `| ${cells.join(" | ")} |`).join("\n");

const kStages = [
  "new_volume",
  "cast",
  "filter",
  "light",
  "finish",
  "read_back",
  "camera",
  "light_moved",
  "frame",
  "whole_volume",
  "whole_prepare",
  "cast_unskipped",
];
const times = table(
  ["row", ...kStages.map((stage) => stage.replace("_", " "))],
  Object.keys(rows).map((row) => [`\`${row}\``, ...kStages.map((stage) => digits(p50(row, stage)))]),
);

// What was aimed at. A row that was not measured has no line.
const passes = ["cast", "filter", "light", "finish"].reduce((sum, stage) => sum + (p50("r1/paper", stage) ?? NaN), 0);
const rated = pipeline?.rows.find(({ name }) => name === "r1/paper")?.pipelined.volumes_a_second_p50;
const stages = Object.entries(rows["r1/paper"]?.stages_ms ?? {}).filter(
  ([stage]) => !["whole_volume", "whole_prepare", "cast_unskipped"].includes(stage),
);
const slow = stages.filter(([, { p50 }]) => p50 > 2).map(([stage, { p50 }]) => `${stage} ${digits(p50)}`);
const aims = [
  ["`r1/paper`: passes 1 to 3 of a new volume", "1 ms", passes, passes < 1, "ms"],
  ["`r1/paper`: the light's pass", "0.2 ms", p50("r1/paper", "light"), p50("r1/paper", "light") < 0.2, "ms"],
  ["`r1/paper`, pipelined: volumes a second", "512", rated, rated >= 512, "a second"],
  [
    "`picture/2880` (as many pixels as 4K): camera moved",
    "16.7 ms",
    p50("picture/2880", "camera"),
    p50("picture/2880", "camera") < 16.7,
    "ms",
  ],
]
  .filter(([, , value]) => value !== undefined && !Number.isNaN(value))
  .map(([what, aim, value, reached, unit]) => [what, aim, `${digits(value)} ${unit}`, reached ? "yes" : "no"]);
if (stages.length > 0)
  aims.push([
    "`r1/paper`: a stage longer than 2 ms, but for whole volumes",
    "none",
    slow.join(", ") || "none",
    slow.length === 0 ? "yes" : "no",
  ]);

const percent = (share) => `${(100 * share).toFixed(0)} %`;
const overlap = table(
  [
    "row",
    "one at a time",
    "pipelined",
    "live",
    "of passes 2 and 3 in another volume's pass 1",
    "of uploads",
    "of read-backs",
  ],
  (pipeline?.rows ?? []).map(({ name, serial, pipelined, live, shares }) => [
    `\`${name}\``,
    ...[serial, pipelined, live].map(({ volumes_a_second_p50 }) => digits(volumes_a_second_p50)),
    percent(shares.light_in_cast),
    percent(shares.upload_in_work),
    percent(shares.read_back_in_work),
  ]),
);
const rates = table(
  ["row", "frames come", "volumes a second", "dropped", "latency p50, p95"],
  (rate?.rows ?? []).flatMap(({ name, ways }) =>
    ways.map((way) => [
      `\`${name}\``,
      way.frames_come,
      digits(way.volumes_a_second_p50),
      way.dropped,
      `${digits(way.latency_ms.p50)}, ${digits(way.latency_ms.p95)} ms`,
    ]),
  ),
);
const parts = table(
  ["part", "MB"],
  (memory?.parts ?? []).map(({ name, mb }) => [name, mb.toFixed(1)]),
);

const stood = kind === "processor in place of a GPU";
const [date, time] = new Date().toISOString().split(/[T.]/);
const section = (title, text, present) => (present ? [`## ${title}`, text, ""] : []);
const text = [
  `# ${device}, ${date}, ${time.slice(0, 5)} UTC`,
  "",
  `${kind}, driver ${driver}; ${cpus().length} processors (${cpus()[0]?.model}). Commit ` +
    `${line("git", "rev-parse", "--short", "HEAD")}${line("git", "status", "--porcelain") === "" ? "" : " with changes"}` +
    ". `tests/run gpu-machine`.",
  ...(stood
    ? [
        "",
        "**No GPU.** A driver that renders on the processor was used as one of a GPU. The tests count, the " +
          "times do not.",
      ]
    : []),
  "",
  "## Tests, with the validation layers",
  readFileSync(join(figures, "tests"), "utf8")
    .trim()
    .split("\n")
    .map((each) => `    ${each}`)
    .join("\n"),
  "",
  ...section("Aims", table(["what", "aim", "measured", "reached"], aims), aims.length > 0),
  "## Times",
  "`fanlight bench`, medians, ms.",
  "",
  times,
  "",
  ...section("Volumes a second, and what overlaps", `${pipeline?.mechanism}\n\n${overlap}`, pipeline),
  ...section("A source of 1000 sweeps a second, newest first", rates, rate),
  ...section(
    "Memory of the process, without the GPU's own: MB that each step added, and pages of files",
    parts,
    memory,
  ),
].join("\n");
const file = join(
  output,
  `${date}-${time.slice(0, 5).replace(":", "")}-${device
    .replace(/[^A-Za-z0-9]+/g, "-")
    .replace(/-$/, "")
    .slice(0, 40)}.md`,
);
writeFileSync(file, text);
console.log(`report: ${file}`);
