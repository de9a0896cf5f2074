// SPDX-License-Identifier: Apache-2.0
// Asks the real program whether it takes what the containers give it: arguments, variables, configuration, shards.
import { execFileSync, spawnSync } from "node:child_process";
import {
  existsSync,
  mkdirSync,
  mkdtempSync,
  readdirSync,
  readFileSync,
  rmSync,
  symlinkSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { environmentOf, podOf } from "./rules.mjs";

const kMost = { encoding: "utf8", timeout: 60_000 };
const kIndex = 1;

export class Program {
  #work = mkdtempSync(join(tmpdir(), "fanlight-kubernetes-"));

  /** `fanlight`: path of the program. Makes a certificate, a token and two small recordings. */
  constructor(fanlight) {
    this.fanlight = fanlight;
    mkdirSync(join(this.#work, "bin"));
    symlinkSync(fanlight, join(this.#work, "bin/fanlight"));
    const file = (name) => join(this.#work, name);
    const quietly = { ...kMost, stdio: "pipe" };
    const subject = "-x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -noenc -days 2 -subj /CN=fanlight".split(" ");
    execFileSync("openssl", ["req", ...subject, "-keyout", file("tls.key"), "-out", file("tls.crt")], quietly);
    const token = ["token", "add", "--tokens", file("tokens.toml"), "--name", "a display", "--role", "viewer"];
    execFileSync(fanlight, token, quietly);
    mkdirSync(file("archive"));
    for (const number of [1, 2]) {
      const source = `phantom:scene=relief,probe=r1,columns=32,rows=32,frames=8,rate=100,volumes=2,seed=${number}`;
      const out = join(file("archive"), `sweep-${number}.igs.mha`);
      execFileSync(fanlight, ["record", source, "--fast", "--out", out], quietly);
    }
    const help = execFileSync(fanlight, ["serve", "--help-all"], kMost);
    this.options = [...help.matchAll(/^ +(?:\S+, )?--([a-z0-9_.-]+)/gm)].map(([, name]) => name);
    if (this.options.length < 100) throw new Error("serve --help-all names too few options: its form has changed");
  }

  remove() {
    rmSync(this.#work, { recursive: true });
  }

  #run(container, extra, environment) {
    const command = [...(container.command ?? ["fanlight"]), ...(container.args ?? []), ...extra];
    const env = { ...environment, PATH: `${join(this.#work, "bin")}:${process.env.PATH}`, HOME: this.#work };
    return spawnSync(command[0], command.slice(1), { ...kMost, env, cwd: this.#work });
  }

  /** Whether each argument and each variable of the container is an option of `fanlight serve`. */
  *#optionProblems(container, environment) {
    const [command, ...rest] = container.args ?? [];
    if (command !== "serve") yield `the container's first argument is ${command}, expected serve`;
    for (const argument of rest.filter((each) => each.startsWith("--"))) {
      const name = argument.slice(2).split("=")[0];
      if (!this.options.includes(name)) yield `fanlight serve has no option --${name}`;
    }
    const variables = this.options.map((name) => `FANLIGHT_${name.replace(/[.-]/g, "_").toUpperCase()}`);
    for (const name of Object.keys(environment)) {
      if (name.startsWith("FANLIGHT_") && !variables.includes(name)) yield `fanlight serve reads no variable ${name}`;
    }
  }

  /** Makes the files that a container mounts below a folder of ours, as its volumes say. Returns that folder. */
  #mount(pod, container, resources) {
    const root = mkdtempSync(join(this.#work, "root-"));
    for (const { name, mountPath } of container.volumeMounts ?? []) {
      const folder = join(root, mountPath);
      mkdirSync(folder, { recursive: true });
      const volume = pod.volumes?.find((each) => each.name === name) ?? {};
      const map = resources.find((each) => each.kind === "ConfigMap" && each.metadata.name === volume.configMap?.name);
      for (const [file, text] of Object.entries(map?.data ?? {})) {
        // The program reads our folder instead of the root; all other text is that of the map.
        const moved = text.replace(/"\/(etc|var)\//g, (match) => `"${root}${match.slice(1)}`);
        writeFileSync(join(folder, file), moved);
      }
      const secrets = { "fanlight-tls": ["tls.crt", "tls.key"], "fanlight-tokens": ["tokens.toml"] };
      for (const file of secrets[volume.secret?.secretName] ?? []) {
        writeFileSync(join(folder, file), readFileSync(join(this.#work, file)), { mode: 0o440 });
      }
    }
    return root;
  }

  /** What the program refuses of a room's container. */
  *serveProblems(workload, resources) {
    const pod = podOf(workload);
    const [container] = pod.containers;
    const environment = environmentOf(container, resources);
    yield* this.#optionProblems(container, environment);
    const root = this.#mount(pod, container, resources);
    const moved = { ...container, args: container.args.map((each) => each.replace(/^\/etc\//, `${root}/etc/`)) };
    const { status, stdout, stderr } = this.#run(moved, ["--print-config"], environment);
    const port = /^listen = ".*:(\d+)"/m.exec(stdout)?.[1];
    const sentence = stderr.trim() || (port ? "" : "it printed no address to listen on");
    // A variable that is almost an option is a warning there.
    if (status !== 0 || sentence !== "") return yield `fanlight serve --print-config: ${sentence} (exit ${status})`;
    const named = container.ports?.find((each) => each.name === "https")?.containerPort;
    if (Number(port) !== named) yield `the server listens on the port ${port}, and the port https is ${named}`;
    // The audit log, and what the variables name, must lie where the container may write.
    const audit = /^audit-log = "([^"]*)"/m.exec(stdout)?.[1];
    const mounts = container.volumeMounts
      .filter((mount) => !mount.readOnly)
      .map((mount) => join(root, mount.mountPath));
    for (const path of [audit, `${root}${environment.XDG_CACHE_HOME}`].filter(Boolean)) {
      if (!mounts.some((mount) => path === mount || path.startsWith(`${mount}/`))) {
        yield `${path.slice(root.length)} lies in no volume that can be written`;
      }
    }
  }

  /** What is wrong with the shards of the Job: its index 1 of a manifest of two sweeps must render the second alone. */
  *batchProblems(job) {
    const [container] = podOf(job).containers;
    const folder = mkdtempSync(join(this.#work, "batch-"));
    const own = environmentOf(container, []);
    const environment = { ...own, MANIFEST: join(folder, "sweeps.toml"), JOB_COMPLETION_INDEX: String(kIndex) };
    environment.XDG_CACHE_HOME = this.#work;
    const sweep = (number) => `[[sweep]]\ninput = "${join(this.#work, `archive/sweep-${number}.igs.mha`)}"\n`;
    writeFileSync(environment.MANIFEST, `folder = "out"\n[all]\nsize = "64x64"\n${sweep(1)}${sweep(2)}`);
    const done = this.#run(container, [], environment);
    const out = join(folder, "out");
    const records = existsSync(out) ? readdirSync(out).filter((name) => name.endsWith(".json")) : [];
    if (done.status !== 0 || records.join() !== "sweep-2.json") {
      yield `index ${kIndex} rendered ${records.join() || "nothing"}, expected sweep-2 (${done.stderr.trim()})`;
    }
    writeFileSync(environment.MANIFEST, '[all]\nsize = "nothing"\n[[sweep]]\n');
    const refused = this.#run(container, [], environment);
    const rule = job.spec.podFailurePolicy.rules.find((each) => each.action === "FailJob")?.onExitCodes;
    const fails = rule?.operator === "In" && rule.values.includes(refused.status) && rule.values.length === 1;
    if (!fails || rule.containerName !== container.name || refused.status === 0) {
      yield `a wrong manifest ends with ${refused.status}, on which the Job does not fail at once`;
    }
  }
}
