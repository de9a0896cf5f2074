// SPDX-License-Identifier: Apache-2.0
// Sends a still to the hospital's archive: the server puts it into a queue on its disk.
import { callApi } from "./api";
import { element } from "./element";
import { PatientForm } from "./patient_form";

export interface ArchiveEvents {
  /** The picture as PNG; undefined where there is none, which has been said. */
  still(): Promise<Blob> | undefined;
  sent(sentence: string): void;
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
  private picture: Promise<Blob> | undefined;

  constructor(
    private readonly button: HTMLButtonElement,
    private readonly events: ArchiveEvents,
  ) {
    const title = element("h2", { id: "archive-title" }, "Send a still to the archive");
    const cancel = element("button", { type: "button" }, "Cancel");
    cancel.onclick = () => this.dialog.close();
    const form = element("form", { autocomplete: "off" }, title, this.patient.root, this.state, this.problem);
    form.append(element("div", { className: "buttons" }, cancel, this.send));
    form.onsubmit = (event) => {
      event.preventDefault();
      void this.submit();
    };
    this.dialog.setAttribute("aria-labelledby", title.id);
    this.dialog.append(form);
    document.body.append(this.dialog);
    button.onclick = () => this.open();
  }

  /** Whether this display's role may send; the server may have no queue. */
  allow(may: boolean): void {
    this.button.hidden = true;
    if (may) void this.ask().then((state) => (this.button.hidden = !state?.available));
  }

  private open(): void {
    this.picture = this.events.still(); // of this moment
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

  private async submit(): Promise<void> {
    const patient = this.patient.patient();
    if (!patient || !this.picture) return;
    this.send.disabled = true;
    this.problem.textContent = "";
    try {
      await callApi("api/archive", { png: await base64Of(await this.picture), patient });
      this.dialog.close();
      this.events.sent("The still waits in the queue for the archive.");
    } catch (error) {
      this.problem.textContent = `Not sent: ${(error as Error).message}`;
    }
    this.send.disabled = false;
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
