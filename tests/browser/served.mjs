// A running server, ended by its process id.
import { spawn } from "node:child_process";
import { once } from "node:events";

const kStartMs = 60_000;
const kEndMs = 10_000;

export class Served {
  #process;
  #output = "";

  /** Resolves when the server says where it listens; `port` 0 takes a free one. `more`: options. */
  static async start(source, port = 0, more = []) {
    const served = new Served();
    await served.#begin(source, port, more);
    return served;
  }

  async #begin(source, port, more) {
    const binary = process.env.FANLIGHT_BIN;
    if (!binary) throw new Error("FANLIGHT_BIN is not set, expected the path of the fanlight binary");
    const command = [binary, "serve", "--source", source, "--listen", `127.0.0.1:${port}`, ...more];
    this.#process = spawn(command[0], command.slice(1), { stdio: ["ignore", "pipe", "pipe"] });
    try {
      await new Promise((resolve, reject) => {
        const fail = (why) => reject(new Error(`${command.join(" ")}: ${why}\n${this.#output}`));
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

  /** What it printed last, for a failure's text. */
  get output() {
    return this.#output;
  }

  /** Sends the signal and waits; a server that does not go within kEndMs is killed. */
  async end(signal = "SIGTERM") {
    const child = this.#process;
    if (child.pid === undefined || child.exitCode !== null || child.signalCode !== null) return;
    const gone = once(child, "exit");
    child.kill(signal);
    const timer = setTimeout(() => child.kill("SIGKILL"), kEndMs);
    await gone;
    clearTimeout(timer);
  }
}
