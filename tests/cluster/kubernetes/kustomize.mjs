// SPDX-License-Identifier: Apache-2.0
// Builds an overlay: the part of kustomize that deploy/kubernetes uses, since Debian 12 has no kustomize with components.
// Where a kustomize or a kubectl is installed that has them, check.mjs compares the two. Whatever this file does not
// know is refused, so that it never builds something else than kustomize would.
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync, readFileSync, statSync } from "node:fs";
import { basename, join, normalize } from "node:path";
import { parseAllDocuments } from "yaml";

const kKeys = ["apiVersion", "kind", "namespace", "resources", "components", "configMapGenerator", "patches", "images"];
// Lists whose entries are merged by a key, as the API declares them. All other lists are replaced.
const kMergeKeys = {
  containers: "name",
  initContainers: "name",
  volumes: "name",
  env: "name",
  volumeMounts: "mountPath",
};
// Also merged by a key, which differs from kind to kind.
const kUnknownLists = ["ports", "imagePullSecrets", "hostAliases", "volumeDevices", "topologySpreadConstraints"];

/** The documents of a file. YAML 1.1, as Kubernetes reads it: 0440 is an octal number. */
export function documentsOf(path) {
  if (!existsSync(path) || !statSync(path).isFile()) throw new Error(`${path}: there is no such file`);
  return parseAllDocuments(readFileSync(path, "utf8"), { version: "1.1" }).map((document) => {
    const trouble = [...document.errors, ...document.warnings][0];
    if (trouble) throw new Error(`${path}: ${trouble.message}`);
    return document.toJS();
  });
}

const isMap = (value) => value !== null && typeof value === "object" && !Array.isArray(value);
const idOf = (resource) => `${resource.kind} ${resource.metadata.name}`;

/** A strategic merge of a patch into a resource, in place. */
function merge(target, patch, path) {
  for (const [name, value] of Object.entries(patch)) {
    const place = `${path}.${name}`;
    if (name.startsWith("$")) throw new Error(`${place}: directives are not supported`);
    if (value === null) {
      delete target[name];
    } else if (isMap(value) && isMap(target[name])) {
      merge(target[name], value, place);
    } else if (Array.isArray(value) && kMergeKeys[name] && Array.isArray(target[name])) {
      mergeList(target[name], value, kMergeKeys[name], place);
    } else if (Array.isArray(value) && kUnknownLists.includes(name) && target[name]) {
      throw new Error(`${place}: patches of this list are not supported`);
    } else {
      target[name] = withoutNulls(value);
    }
  }
}

function mergeList(target, patch, key, path) {
  for (const entry of patch) {
    if (entry[key] === undefined) throw new Error(`${path}: an entry lacks its ${key}`);
    const same = target.find((each) => each[key] === entry[key]);
    if (same) merge(same, entry, `${path}[${entry[key]}]`);
    else target.push(withoutNulls(entry));
  }
}

function withoutNulls(value) {
  if (Array.isArray(value)) return value.map(withoutNulls);
  if (!isMap(value)) return value;
  return Object.fromEntries(
    Object.entries(value)
      .filter(([, each]) => each !== null)
      .map(([name, each]) => [name, withoutNulls(each)]),
  );
}

function generate(resources, generator, folder) {
  const data = {};
  for (const file of generator.files ?? []) {
    const path = join(folder, file);
    if (!existsSync(path)) throw new Error(`${path}: there is no such file`);
    data[basename(file)] = readFileSync(path, "utf8");
  }
  for (const literal of generator.literals ?? []) {
    const equals = literal.indexOf("=");
    if (equals < 1) throw new Error(`${folder}: the literal ${literal} is no NAME=VALUE`);
    data[literal.slice(0, equals)] = literal.slice(equals + 1);
  }
  const old = resources.find((each) => each.kind === "ConfigMap" && each.metadata.name === generator.name);
  if (generator.behavior === "merge") {
    if (!old) throw new Error(`${folder}: there is no ConfigMap ${generator.name} to merge with`);
    Object.assign(old.data, data);
  } else if (generator.behavior !== undefined || old) {
    throw new Error(`${folder}: the ConfigMap ${generator.name} is there already, or its behavior is not supported`);
  } else {
    resources.push({ apiVersion: "v1", kind: "ConfigMap", metadata: { name: generator.name }, data });
  }
}

function applyPatch(resources, patch, folder) {
  if (Object.keys(patch).join() !== "path") throw new Error(`${folder}: only patches by path are supported`);
  for (const document of documentsOf(join(folder, patch.path))) {
    const target = resources.find((each) => idOf(each) === idOf(document) && each.apiVersion === document.apiVersion);
    if (!target) throw new Error(`${folder}: no resource ${idOf(document)} for the patch ${patch.path}`);
    merge(target, document, idOf(document));
  }
}

function addResources(resources, names, folder, visited) {
  for (const name of names) {
    const path = normalize(join(folder, name));
    if (existsSync(path) && statSync(path).isDirectory()) {
      accumulate(resources, path, "Kustomization", visited);
      continue;
    }
    visited.add(path);
    for (const document of documentsOf(path)) {
      if (resources.some((each) => idOf(each) === idOf(document))) {
        throw new Error(`${path}: there are two of ${idOf(document)}`);
      }
      resources.push(document);
    }
  }
}

const podSpecOf = (resource) => resource.spec?.template?.spec;

function accumulate(resources, folder, kind, visited) {
  const path = join(folder, "kustomization.yaml");
  const [kustomization] = documentsOf(path);
  const unknown = Object.keys(kustomization).find((key) => !kKeys.includes(key));
  if (unknown) throw new Error(`${path}: the key ${unknown} is not supported`);
  if (kustomization.kind !== kind) throw new Error(`${path}: its kind is ${kustomization.kind}, expected ${kind}`);
  visited.add(path);
  // The order is that of kustomize: a folder's own generators and patches come after its components.
  addResources(resources, kustomization.resources ?? [], folder, visited);
  for (const component of kustomization.components ?? []) {
    accumulate(resources, normalize(join(folder, component)), "Component", visited);
  }
  for (const generator of kustomization.configMapGenerator ?? []) {
    generate(resources, generator, folder);
    for (const file of generator.files ?? []) visited.add(join(folder, file));
  }
  for (const patch of kustomization.patches ?? []) {
    applyPatch(resources, patch, folder);
    visited.add(join(folder, patch.path));
  }
  for (const resource of resources) {
    if (kustomization.namespace === undefined) break;
    if (resource.kind === "Namespace") resource.metadata.name = kustomization.namespace;
    else resource.metadata.namespace = kustomization.namespace;
  }
  for (const image of kustomization.images ?? []) {
    for (const container of resources.flatMap((each) => podSpecOf(each)?.containers ?? [])) {
      if (container.image !== image.name) continue;
      container.image = `${image.newName ?? image.name}${image.newTag ? `:${image.newTag}` : ""}`;
    }
  }
}

/** The end of a generated name, by the content. Of the form of kustomize, and not the same. */
function hashOf({ data }) {
  const digits = createHash("sha256").update(JSON.stringify(data)).digest("hex").slice(0, 10);
  return digits.replace(/[013ae]/g, (digit) => ({ 0: "g", 1: "h", 3: "k", a: "m", e: "t" })[digit]);
}

function addHashes(resources) {
  const names = new Map();
  for (const map of resources.filter((each) => each.kind === "ConfigMap")) {
    names.set(map.metadata.name, `${map.metadata.name}-${hashOf(map)}`);
    map.metadata.name = names.get(map.metadata.name);
  }
  const rename = (reference) => {
    if (reference && names.has(reference.name)) reference.name = names.get(reference.name);
  };
  for (const pod of resources.map(podSpecOf).filter(Boolean)) {
    pod.volumes?.forEach((volume) => rename(volume.configMap));
    for (const container of pod.containers) {
      container.envFrom?.forEach((source) => rename(source.configMapRef));
      container.env?.forEach((variable) => rename(variable.valueFrom?.configMapKeyRef));
    }
  }
}

/** The resources of an overlay. Adds each file that was read to `visited`. Throws a sentence where it cannot be built. */
export function build(folder, visited = new Set()) {
  const resources = [];
  accumulate(resources, normalize(folder), "Kustomization", visited);
  addHashes(resources);
  return resources;
}

/** The command of a kustomize that knows components (4.1 or newer), with its version; or why there is none. */
export function realKustomize() {
  const tries = [
    { command: ["kustomize", "build"], version: ["kustomize", "version"] },
    { command: ["kubectl", "kustomize"], version: ["kubectl", "version", "--client", "-o", "yaml"] },
  ];
  const found = [];
  for (const { command, version } of tries) {
    try {
      const text = execFileSync(version[0], version.slice(1), {
        encoding: "utf8",
        stdio: ["ignore", "pipe", "ignore"],
      });
      const number = /(?:kustomizeVersion: |kustomize\/|^)v(\d+)\.(\d+)\.\d+/m.exec(text);
      if (number && (number[1] > 4 || (number[1] === "4" && number[2] >= 1))) {
        return { command, name: `${command.join(" ")} ${number[0].replace(/^.*[ /]/, "")}` };
      }
      found.push(`${command[0]} is too old`);
    } catch {
      found.push(`there is no ${command[0]}`);
    }
  }
  return { reason: found.join(", ") };
}

/** The same by a real kustomize. */
export function buildForReal({ command }, folder) {
  const text = execFileSync(command[0], [...command.slice(1), folder], { encoding: "utf8", stdio: "pipe" });
  return parseAllDocuments(text, { version: "1.1" }).map((document) => document.toJS());
}

/** For comparisons: the order of resources, keys and merged lists means nothing, nor does a hash in a name. */
function canonical(value, name = "") {
  if (typeof value === "string") return value.replace(/-[bcdfghkmt2-9]{10}$/, "-HASH");
  if (Array.isArray(value)) {
    const list = value.map((each) => canonical(each));
    const key = kMergeKeys[name];
    return key ? list.sort((a, b) => (a[key] < b[key] ? -1 : 1)) : list;
  }
  if (!isMap(value)) return value;
  return Object.fromEntries(
    Object.entries(value)
      .sort(([a], [b]) => (a < b ? -1 : 1))
      .map(([key, each]) => [key, canonical(each, key)]),
  );
}

export function canonicalAll(resources) {
  return resources.map((each) => canonical(each)).sort((a, b) => (idOf(a) < idOf(b) ? -1 : 1));
}
