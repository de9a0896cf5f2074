// SPDX-License-Identifier: Apache-2.0
// Sends a still, a clip or a volume to the hospital's archive: the server puts it into a queue on its disk.
import type { ArchiveForm } from "./archive_form";
import { queueState } from "./archive_queue";

export interface ArchiveEvents {
  /** The picture as PNG; undefined where there is none, which has been said. */
  still(): Promise<Blob> | undefined;
  /** The picture of this moment, of a clip; undefined, without a word, where there is none. */
  frame(): Promise<HTMLCanvasElement> | undefined;
  /** How the picture came, where it has lost something on the way. */
  loss(): Loss | undefined;
  /** The volume on show, where it is frozen for all displays. */
  frozenVolume(): bigint | undefined;
  sent(sentence: string): void;
  failed(sentence: string): void;
}

export interface Loss {
  method: "jpeg" | "h264";
  /** By how much it was compressed. */
  ratio: number;
}

export class ArchiveButton {
  private form: ArchiveForm | undefined;
  private asked = 0;

  constructor(
    private readonly button: HTMLButtonElement,
    private readonly events: ArchiveEvents,
  ) {
    button.onclick = () => void this.open();
  }

  /** Whether this display's role may send; the server may have no queue. */
  allow(may: boolean): void {
    const asked = ++this.asked; // an earlier answer comes too late
    this.button.hidden = true;
    if (!may) return this.form?.forget();
    void queueState().then((state) => {
      if (asked === this.asked) this.button.hidden = !state?.available;
    });
  }

  private async open(): Promise<void> {
    // Of this moment.
    const [picture, loss, volume] = [this.events.still(), this.events.loss(), this.events.frozenVolume()];
    if (!picture) return;
    picture.catch(() => undefined); // the form says it
    this.button.disabled = true; // a second click would open it twice
    try {
      const { ArchiveForm: Form } = (await import("./archive_form.js")) as typeof import("./archive_form");
      this.form ??= new Form(this.button, this.events);
    } catch (error) {
      return this.events.failed(`The form of the archive could not be loaded: ${(error as Error).message}`);
    } finally {
      this.button.disabled = false;
    }
    if (!this.button.hidden) this.form.open({ picture, loss, volume }); // the role may have changed meanwhile
  }
}
