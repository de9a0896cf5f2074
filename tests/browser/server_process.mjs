// SPDX-License-Identifier: Apache-2.0
// Starts and stops a Fanlight server as a child process. Signals go to the id of the child only.
import { spawn } from "node:child_process";
import { once } from "node:events";

const kStartMs = 60_000;
const kEndMs = 10_000;

export class ServerProcess {
  #process;
  #output = "";

  /**
   * Resolves when the server has printed its address; rejects after kStartMs, or when it exits before.
   * `port`: 0 selects a free port. `options`: further command line options.
   */
  static async start(source, port = 0, options = []) {
    const server = new ServerProcess();
    await server.#spawn(source, port, options);
    return server;
  }

  async #spawn(source, port, options) {
    const binary = process.env.FANLIGHT_BIN;
    if (!binary) throw new Error("FANLIGHT_BIN is not set, expected the path of the fanlight binary");
    const command = [binary, "serve", "--source", source, "--listen", `127.0.0.1:${port}`, ...options];
    this.#process = spawn(command[0], command.slice(1), { stdio: ["ignore", "pipe", "pipe"] });
    try {
      await new Promise((resolve, reject) => {
        const fail = (reason) => reject(new Error(`${command.join(" ")}: ${reason}\n${this.#output}`));
        const timer = setTimeout(() => fail(`printed no http://127.0.0.1:PORT/ within ${kStartMs / 1000} s`), kStartMs);
        const read = (text) => {
          this.#output = (this.#output + text).slice(-20_000);
          const found = /http:\/\/127\.0\.0\.1:(\d+)\//.exec(this.#output);
          if (!found || this.url) return;
          [this.url, this.port] = [found[0], Number(found[1])];
          clearTimeout(timer);
          resolve();
        };
        this.#process.stdout.on("data", read);
        this.#process.stderr.on("data", (text) => {
          this.#output = (this.#output + text).slice(-20_000);
        });
        this.#process.on("error", (error) => {
          clearTimeout(timer);
          fail(error.message);
        });
        this.#process.on("exit", (code, signal) => {
          clearTimeout(timer);
          fail(`ended with ${signal ?? code}`);
        });
      });
    } catch (error) {
      await this.end("SIGKILL");
      throw error;
    }
  }

  /** The last 20 000 characters that the server printed, for error messages. */
  get output() {
    return this.#output;
  }

  get pid() {
    return this.#process.pid;
  }

  /** Sends the signal, such as SIGSTOP, and does not wait. */
  send(signal) {
    this.#process.kill(signal);
  }

  /** Sends the signal and waits for the exit. Kills a server that has not exited after kEndMs. */
  async end(signal = "SIGTERM") {
    const child = this.#process;
    if (child.pid === undefined || child.exitCode !== null || child.signalCode !== null) return;
    const exited = once(child, "exit");
    child.kill(signal);
    child.kill("SIGCONT"); // a stopped process takes no signal
    const timer = setTimeout(() => child.kill("SIGKILL"), kEndMs);
    await exited;
    clearTimeout(timer);
  }
}
