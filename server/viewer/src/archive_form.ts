// SPDX-License-Identifier: Apache-2.0
// The form that sends a still to the hospital's archive. Loaded when it is first opened (archive_button.ts).
import { callApi } from "./api";
import type { ArchiveEvents, Loss } from "./archive_button";
import { queueState, type QueueState } from "./archive_queue";
import { element } from "./element";
import { PatientForm } from "./patient_form";

export class ArchiveForm {
  private readonly dialog = element("dialog", { id: "archive-form" });
  private readonly state = element("p", {});
  private readonly problem = element("p", { className: "problem", role: "alert" });
  private readonly send = element("button", { type: "submit" }, "Send");
  private readonly patient = new PatientForm((sentence) => (this.problem.textContent = sentence));
  private readonly cancel = element("button", { type: "button" }, "Cancel");
  private picture: Promise<Blob> | undefined;
  private loss: Loss | undefined;
  private isBusy = false;

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
  }

  /** Another person may sit there now. */
  forget(): void {
    this.patient.forget();
  }

  open(picture: Promise<Blob>, loss: Loss | undefined): void {
    [this.picture, this.loss] = [picture, loss];
    picture.catch((error: Error) => (this.problem.textContent = error.message));
    this.problem.textContent = "";
    this.state.textContent = "";
    this.dialog.showModal();
    void queueState().then((state) => state && this.tell(state));
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
