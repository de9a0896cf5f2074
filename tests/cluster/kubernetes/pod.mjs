// SPDX-License-Identifier: Apache-2.0
// Runs the container of a pod on this machine, as near to a kubelet as namespaces get: the process is number 1, its root
// cannot be written, and it has the user, the groups, the variables and the volumes that the pod names, no capability,
// and the network of the caller. Needs root.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { chmodSync, chownSync, mkdirSync, readFileSync, renameSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { request } from "node:https";
import { join } from "node:path";
import { setTimeout as pause } from "node:timers/promises";
import { environmentOf, podOf } from "./rules.mjs";

// Arguments: a folder for the root, the program, volumes as PATH=FOLDER=ro|rw, "--", and the command with its user.
// This machine's libraries and a program of the build tree stand in for the image.
const kRun = `set -e
root="$1" program="$2"; shift 2
mount -t tmpfs none "$root"
mkdir -p "$root/usr" "$root/etc" "$root/proc" "$root/dev" "$root/opt/bin" "$root/var"
mount --bind /usr "$root/usr"
for link in bin sbin lib lib64; do ln -s "usr/$link" "$root/$link"; done
cp -a /etc/ld.so.cache /etc/alternatives /etc/ssl /etc/nsswitch.conf /etc/passwd /etc/group "$root/etc"
cp "$program" "$root/opt/bin/fanlight"
mount -t proc none "$root/proc"
mount --rbind /dev "$root/dev"
volumes=()
while [[ "$1" != -- ]]; do volumes+=("$1"); mkdir -p "$root\${1%%=*}"; shift; done
shift
mount -o remount,ro "$root"
for volume in "\${volumes[@]}"; do
  IFS== read -r path folder mode <<<"$volume"
  mount --bind "$folder" "$root$path"
  [[ "$mode" == rw ]] || mount -o remount,bind,ro "$root$path"
done
exec /usr/sbin/chroot "$root" "$@"`;

/** Writes files as a kubelet does: behind the link ..data, which one step replaces. `group`: of those that may read. */
export function writeVolume(folder, files, group) {
  const version = `..${process.hrtime.bigint()}`;
  mkdirSync(join(folder, version), { recursive: true });
  for (const [name, text] of Object.entries(files)) {
    const path = join(folder, version, name);
    writeFileSync(path, text);
    chownSync(path, 0, group);
    chmodSync(path, 0o440);
    rmSync(join(folder, name), { force: true });
    symlinkSync(`..data/${name}`, join(folder, name));
  }
  symlinkSync(version, join(folder, "..data.new"));
  renameSync(join(folder, "..data.new"), join(folder, "..data"));
}

export class Pod {
  #process;
  #folder;
  #output = "";

  /**
   * Starts the only container of a workload. `folder`: for its volumes and root. `secrets`: the files of each Secret by
   * its name and theirs. Volumes that can be written are empty, as those of a new pod.
   */
  constructor(fanlight, workload, resources, folder, secrets) {
    this.#folder = folder;
    const pod = podOf(workload);
    const [container] = pod.containers;
    this.container = container;
    const { runAsUser, runAsGroup, fsGroup } = pod.securityContext;
    mkdirSync(join(folder, "root"), { recursive: true });
    chmodSync(folder, 0o755);
    const volumes = container.volumeMounts.map(({ name, mountPath, readOnly }) => {
      const own = this.volume(name);
      mkdirSync(own);
      const volume = pod.volumes.find((each) => each.name === name);
      const map = resources.find((each) => each.kind === "ConfigMap" && each.metadata.name === volume.configMap?.name);
      const files = map?.data ?? secrets[volume.secret?.secretName];
      if (files) writeVolume(own, files, fsGroup);
      else (chownSync(own, 0, fsGroup), chmodSync(own, 0o2777));
      return `${mountPath}=${own}=${readOnly ? "ro" : "rw"}`;
    });
    const limits = { "limits.cpu": container.resources.limits.cpu };
    const env = { PATH: "/opt/bin:/usr/bin:/bin", ...environmentOf(container, resources) };
    for (const { name, valueFrom } of container.env) {
      if (valueFrom) env[name] = limits[valueFrom.resourceFieldRef.resource];
    }
    const user = [`--reuid=${runAsUser}`, `--regid=${runAsGroup}`, `--groups=${fsGroup}`];
    const caged = ["setpriv", ...user, "--bounding-set=-all", "--inh-caps=-all", "--no-new-privs"];
    const command = [...caged, ...container.command, ...container.args];
    const namespaces = ["--mount", "--propagation=private", "--pid", "--fork", "--kill-child", "--uts", "--ipc"];
    const run = ["bash", "-c", kRun, "pod", join(folder, "root"), fanlight, ...volumes, "--", ...command];
    this.#process = spawn("unshare", [...namespaces, ...run], { env, stdio: ["ignore", "pipe", "pipe"] });
    const keep = (text) => (this.#output = (this.#output + text).slice(-20_000));
    this.#process.stdout.on("data", keep);
    this.#process.stderr.on("data", keep);
  }

  /** The folder of a volume. */
  volume(name) {
    return join(this.#folder, name);
  }

  /** The last 20 000 characters that the container printed. */
  get output() {
    return this.#output;
  }

  get ended() {
    return this.#process.exitCode !== null || this.#process.signalCode !== null;
  }

  /** Its number 1, as this machine counts. */
  get #first() {
    const id = this.#process.pid;
    return Number(readFileSync(`/proc/${id}/task/${id}/children`, "utf8").trim().split(" ")[0]);
  }

  /** The most memory that it had, in MiB. */
  get peakMebibytes() {
    return Number(/VmHWM:\s+(\d+)/.exec(readFileSync(`/proc/${this.#first}/status`, "utf8"))[1]) / 1024;
  }

  /** What the kernel says of number 1: users, groups, capabilities, new privileges. */
  get status() {
    return readFileSync(`/proc/${this.#first}/status`, "utf8");
  }

  /** The answer of a probe of the container: a status, or 0 for none within its time. */
  probe(name) {
    const { httpGet, timeoutSeconds } = this.container[name];
    const port = this.container.ports.find((each) => each.name === httpGet.port).containerPort;
    const options = { host: "127.0.0.1", port, path: httpGet.path, rejectUnauthorized: false, agent: false };
    return new Promise((resolve) => {
      const asked = request({ ...options, timeout: timeoutSeconds * 1000 }, (answer) => {
        answer.resume();
        resolve(answer.statusCode);
      });
      asked.on("timeout", () => asked.destroy());
      asked.on("error", () => resolve(0));
      asked.end();
    });
  }

  /** Resolves when a probe succeeds; rejects when the container ends or `most_s` have passed. */
  async until(name, most_s) {
    const deadline = performance.now() + most_s * 1000;
    while ((await this.probe(name)) !== 200) {
      if (this.ended || performance.now() > deadline) throw new Error(`no success of ${name}\n${this.#output}`);
      await pause(100);
    }
  }

  /** SIGTERM to number 1, and the exit code of the container; SIGKILL and null after `most_s`. */
  async end(most_s) {
    if (this.ended) return this.#process.exitCode;
    const exited = once(this.#process, "exit");
    process.kill(this.#first, "SIGTERM");
    const timer = setTimeout(() => this.#process.kill("SIGKILL"), most_s * 1000);
    const [code] = await exited;
    clearTimeout(timer);
    return code;
  }
}
