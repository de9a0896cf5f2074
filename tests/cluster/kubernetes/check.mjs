// SPDX-License-Identifier: Apache-2.0
// Checks deploy/kubernetes: check.mjs FANLIGHT DEPLOY. Each mistake of mistakes.mjs must be found as well.
import assert from "node:assert/strict";
import { cpSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, relative } from "node:path";
import { build, buildForReal, canonicalAll, documentsOf, realKustomize } from "./kustomize.mjs";
import { mistakes } from "./mistakes.mjs";
import { Program } from "./program.mjs";
import { ruleProblems, workloadsOf } from "./rules.mjs";
import { schemaProblems, spoilt } from "./schemas.mjs";

const [fanlight, deploy] = process.argv.slice(2);
const kFolder = "kubernetes";

const secretsIn = (folder) =>
  [...readFileSync(join(folder, "README.md"), "utf8").matchAll(/create secret \S+ (\S+)/g)].map(([, name]) => name);

const resourcesOf = (path) => (path.endsWith(".yaml") ? documentsOf(path) : build(path));

/** All problems of an overlay, or of batch.yaml, a sentence each. */
function problemsOf(folder, name, program, real) {
  try {
    const path = join(folder, name);
    const resources = resourcesOf(path);
    const wrong = resources.flatMap(schemaProblems);
    // The rules and the program would read fields that are not there.
    if (wrong.length > 0) return wrong;
    const problems = ruleProblems(resources, secretsIn(folder));
    if (problems.length > 0) return problems;
    for (const workload of workloadsOf(resources)) {
      const asked =
        workload.kind === "Job" ? program.batchProblems(workload) : program.serveProblems(workload, resources);
      problems.push(...asked);
    }
    if (real?.command && !name.endsWith(".yaml")) {
      const theirs = buildForReal(real, path);
      assert.deepEqual(canonicalAll(resources), canonicalAll(theirs), `${real.name} builds other resources`);
    }
    return problems;
  } catch (error) {
    return [String(error.stderr || error.message)];
  }
}

function filesIn(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) =>
    entry.isDirectory() ? filesIn(join(folder, entry.name)) : [join(folder, entry.name)],
  );
}

const namesIn = (folder) => [...readdirSync(join(folder, "overlays")).map((name) => `overlays/${name}`), "batch.yaml"];

/** Files that no overlay uses. */
function fileProblems(folder) {
  const visited = new Set([join(folder, "README.md"), join(folder, "batch.yaml")]);
  for (const name of namesIn(folder)) if (name !== "batch.yaml") build(join(folder, name), visited);
  const unused = filesIn(folder).filter((file) => !visited.has(file));
  return unused.map((file) => `${relative(folder, file)}: no overlay uses it`);
}

/** Why a mistake was not found; null where it was. `copy`: of the folder; it gets the mistake for a moment. */
function missed(mistake, copy, program) {
  const file = join(copy, mistake.file);
  const text = readFileSync(file, "utf8");
  const changed = text.replace(mistake.from, () => mistake.to);
  if (changed === text) return `${mistake.name}: ${mistake.file} has no "${mistake.from}" any more`;
  writeFileSync(file, changed);
  let found;
  if (mistake.of === "files") found = fileProblems(copy);
  else found = problemsOf(copy, mistake.of, program, null);
  writeFileSync(file, text);
  if (found.some((problem) => mistake.expect.test(problem))) return null;
  return `${mistake.name}: not found; found was: ${found.join("; ") || "nothing"}`;
}

const scratch = mkdtempSync(join(tmpdir(), "fanlight-mistakes-"));
const program = new Program(fanlight);
const problems = [];
try {
  const folder = join(deploy, kFolder);
  const real = realKustomize();
  const names = namesIn(folder);
  for (const name of names) {
    problems.push(...problemsOf(folder, name, program, real).map((problem) => `${name}: ${problem}`));
  }
  console.log(`${names.length - 1} overlays and batch.yaml were checked`);
  console.log(real.command ? `${real.name} was compared` : `not compared with a kustomize: ${real.reason}`);
  if (problems.length === 0) {
    problems.push(...fileProblems(folder));
    const all = names.flatMap((name) => resourcesOf(join(folder, name)));
    let spoils = 0;
    for (const { place, resource } of all.flatMap((resource) => [...spoilt(resource)])) {
      spoils += 1;
      if (schemaProblems(resource).length === 0)
        problems.push(`${resource.kind}: the schema allows anything at ${place}`);
    }
    cpSync(folder, scratch, { recursive: true });
    problems.push(...mistakes.map((mistake) => missed(mistake, scratch, program)).filter(Boolean));
    // Without a mistake nothing is found in the copy either.
    for (const name of names) problems.push(...ruleProblems(resourcesOf(join(scratch, name)), secretsIn(scratch)));
    console.log(`${all.length} resources, ${spoils} spoilt fields and ${mistakes.length} mistakes were tried`);
  }
} finally {
  program.remove();
  rmSync(scratch, { recursive: true });
}
for (const problem of problems) console.error(`kubernetes: ${problem}`);
process.exitCode = problems.length > 0 ? 1 : 0;
