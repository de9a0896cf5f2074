// SPDX-License-Identifier: Apache-2.0
// Sends a still to the hospital's archive: the server puts it into a queue on its disk.
import { callApi } from "./api";
import { element } from "./element";
import { PatientForm } from "./patient_form";

export interface ArchiveEvents {
  /** The picture as PNG; undefined where there is none, which has been said. */
  still(): Promise<Blob> | undefined;
  /** How the picture came, where it has lost something on the way. */
  loss(): Loss | undefined;
  sent(sentence: string): void;
  failed(sentence: string): void;
}

export interface Loss {
  method: "jpeg" | "h264";
  /** By how much it was compressed. */
  ratio: number;
}

interface QueueState {
  available: boolean;
  waiting: number;
  refused: number;
}

export class ArchiveButton {
  private readonly dialog = element("dialog", { id: "archive-form" });
  private readonly state = element("p", {});
  private readonly problem = element("p", { className: "problem", role: "alert" });
  private readonly send = element("button", { type: "submit" }, "Send");
  private readonly patient = new PatientForm((sentence) => (this.problem.textContent = sentence));
  private readonly cancel = element("button", { type: "button" }, "Cancel");
  private picture: Promise<Blob> | undefined;
  private loss: Loss | undefined;
  private isBusy = false;
  private asked = 0;

  constructor(
    private readonly button: HTMLButtonElement,
    private readonly events: ArchiveEvents,
  ) {
    const title = element("h2", { id: "archive-title" }, "Send a still to the archive");
    const which = element("p", {}, "Sends the picture that was on show when this form opened.");
    this.cancel.onclick = () => this.dialog.close();
    const form = element("form", { autocomplete: "off" }, title, which, this.patient.root, this.state, this.problem);
    form.append(element("div", { className: "buttons" }, this.cancel, this.send));
    form.onsubmit = (event) => {
      event.preventDefault();
      void this.submit();
    };
    this.dialog.oncancel = (event) => this.isBusy && event.preventDefault();
    this.dialog.setAttribute("aria-labelledby", title.id);
    this.dialog.append(form);
    document.body.append(this.dialog);
    button.onclick = () => this.open();
  }

  /** Whether this display's role may send; the server may have no queue. */
  allow(may: boolean): void {
    const asked = ++this.asked; // an earlier answer comes too late
    this.button.hidden = true;
    if (!may) return this.patient.forget();
    void this.ask().then((state) => {
      if (asked === this.asked) this.button.hidden = !state?.available;
    });
  }

  private open(): void {
    [this.picture, this.loss] = [this.events.still(), this.events.loss()]; // of this moment
    if (!this.picture) return;
    this.picture.catch((error: Error) => (this.problem.textContent = error.message));
    this.problem.textContent = "";
    this.state.textContent = "";
    this.dialog.showModal();
    void this.ask().then((state) => state && this.tell(state));
  }

  private async ask(): Promise<QueueState | undefined> {
    try {
      return (await (await callApi("api/archive")).json()) as QueueState;
    } catch {
      return undefined; // the server says why when a still is sent
    }
  }

  private tell({ waiting, refused }: QueueState): void {
    const parts = [];
    if (waiting > 0) parts.push(`${waiting} earlier ${waiting === 1 ? "picture waits" : "pictures wait"} to be sent.`);
    if (refused > 0) parts.push(`The archive has refused ${refused}: ask the administrator.`);
    this.state.textContent = parts.join(" ");
  }

  /** While a still is under way the form stays: its answer must not meet the next one. */
  private setBusy(isBusy: boolean): void {
    this.isBusy = isBusy;
    for (const each of [this.send, this.cancel, this.button]) each.disabled = isBusy;
    this.problem.textContent = "";
    this.send.textContent = isBusy ? "Sending…" : "Send";
  }

  private async submit(): Promise<void> {
    const patient = this.patient.patient();
    if (!patient || !this.picture) return;
    this.setBusy(true);
    try {
      await callApi("api/archive", {
        png: await base64Of(await this.picture),
        patient,
        ...(this.loss && { lossy: this.loss }),
      });
      this.dialog.close();
      this.events.sent("The still waits in the queue for the archive.");
    } catch (error) {
      const sentence =
        error instanceof TypeError // of fetch()
          ? "The connection was lost: it is not known whether the still was sent."
          : `The still was not sent: ${(error as Error).message}`;
      this.setBusy(false);
      if (this.dialog.open) {
        this.problem.textContent = sentence;
      } else {
        this.events.failed(sentence); // Escape can close it all the same
      }
    }
    this.isBusy && this.setBusy(false);
  }
}

function base64Of(blob: Blob): Promise<string> {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve((reader.result as string).replace(/^[^,]*,/, ""));
    reader.onerror = () => reject(new Error("the browser cannot read the picture"));
    reader.readAsDataURL(blob);
  });
}
