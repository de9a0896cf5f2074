// SPDX-License-Identifier: Apache-2.0
// How pictures travel to this display.
import type { Connection } from "./connection";
import { canDecodeFilm } from "./film_decoder";

const kJpeg = "0"; // without a request; every browser decodes it
const kH264 = "2";

export class CodecChoice {
  constructor(
    private readonly select: HTMLSelectElement,
    private readonly connection: Pick<Connection, "send">,
  ) {
    select.onchange = () => this.ask();
    select.querySelector<HTMLOptionElement>(`[value="${kH264}"]`)!.disabled = !canDecodeFilm();
  }

  /** A new session begins with JPEG. */
  askAgain(): void {
    if (this.select.value !== kJpeg) this.ask();
  }

  /** The browser cannot decode what was chosen. */
  fallBack(): void {
    this.select.value = kJpeg;
    this.ask();
  }

  private ask(): void {
    this.connection.send({ case: "stream", value: { codec: Number(this.select.value) } });
  }
}
