// SPDX-License-Identifier: Apache-2.0
// How pictures travel to this display.
import type { Connection } from "./connection";
import { canDecodeFilm } from "./film_decoder";
import type { Size } from "./view_geometry";

const kJpeg = "0"; // without a request; every browser decodes it
const kH264 = "2";
const kSurface = "3";

export class CodecChoice {
  private filmWanted = false;
  private isChosen = false; // by the user

  constructor(
    private readonly select: HTMLSelectElement,
    private readonly connection: Pick<Connection, "send">,
    /** The size in which the page shows pictures that it lights itself. */
    private readonly shownSize: () => Size,
  ) {
    select.onchange = () => {
      this.isChosen = true;
      this.ask();
    };
    select.value = kJpeg;
    this.surfaces.disabled = true;
    select.querySelector<HTMLOptionElement>(`[value="${kH264}"]`)!.disabled = !canDecodeFilm();
  }

  /** This display can light surfaces, which it takes unless the user has chosen something else. */
  offerSurfaces(): void {
    this.surfaces.disabled = false;
    if (this.isChosen || this.filmWanted) return;
    this.select.value = kSurface;
    this.ask();
  }

  private get surfaces(): HTMLOptionElement {
    return this.select.querySelector<HTMLOptionElement>(`[value="${kSurface}"]`)!;
  }

  /** A new session begins with JPEG. */
  start(): void {
    if (this.filmWanted || this.select.value !== kJpeg) this.ask();
  }

  get canFilm(): boolean {
    return canDecodeFilm();
  }

  /** H.264 whatever is chosen, as long as it is wanted. */
  wantFilm(wanted: boolean): void {
    this.filmWanted = wanted;
    if (this.select.value !== kH264) this.ask();
  }

  /** The browser cannot show what was chosen. */
  fallBack(): void {
    this.filmWanted = false;
    this.select.value = kJpeg;
    this.ask();
  }

  /** The page shows pictures in another size now. */
  sizeChanged(): void {
    if (!this.filmWanted && this.select.value === kSurface) this.ask();
  }

  /** The server then sends the next picture whole. */
  ask(): void {
    const codec = this.filmWanted ? kH264 : this.select.value;
    // Pictures of the server itself stay small, so that a moved light is quick.
    const size = codec === kSurface ? this.shownSize() : {};
    this.connection.send({ case: "stream", value: { codec: Number(codec), ...size } });
  }
}
