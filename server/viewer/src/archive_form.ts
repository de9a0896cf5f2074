// SPDX-License-Identifier: Apache-2.0
// The form that sends a still, a clip or a volume to the hospital's archive. Loaded when it is first opened (archive_button.ts).
import { callApi } from "./api";
import type { ArchiveEvents, Loss } from "./archive_button";
import { kClipS, recordClip } from "./archive_clip";
import { queueState, type QueueState } from "./archive_queue";
import { element } from "./element";
import { PatientForm } from "./patient_form";

/** What can be sent. */
export interface Sendable {
  picture: Promise<Blob>;
  loss: Loss | undefined;
  /** The frozen one; undefined where none is. */
  volume: bigint | undefined;
}

type What = "picture" | "clip" | "volume";
const kExplanations: Record<What, string> = {
  picture: "Sends the picture that was on show when this form opened.",
  clip: `Records what this display shows from now on, for ${kClipS} s, and sends it.`,
  volume:
    "Sends the echoes of the frozen volume, which other programs can slice and render. Measurements and notes are not in it.",
};
const kNames: Record<What, string> = { picture: "still", clip: "clip", volume: "volume" };
const kFreezeFirst = "To send the volume, freeze the picture first.";

export class ArchiveForm {
  private readonly dialog = element("dialog", { id: "archive-form" });
  private readonly state = element("p", {});
  private readonly problem = element("p", { className: "problem", role: "alert" });
  private readonly send = element("button", { type: "submit" }, "Send");
  private readonly patient = new PatientForm((sentence) => (this.problem.textContent = sentence));
  private readonly cancel = element("button", { type: "button" }, "Cancel");
  private readonly what = element("select", { ariaLabel: "What to send" });
  private readonly explanation = element("p", {});
  private readonly volume = element("option", { value: "volume" }, "Frozen volume");
  private sendable: Sendable | undefined;
  private isBusy = false;

  constructor(
    private readonly button: HTMLButtonElement,
    private readonly events: ArchiveEvents,
  ) {
    const title = element("h2", { id: "archive-title" }, "Send to the archive");
    this.what.append(
      element("option", { value: "picture" }, "Picture"),
      element("option", { value: "clip" }, `Clip of ${kClipS} s`),
      this.volume,
    );
    this.what.onchange = () => this.explain();
    const what = element("label", {}, this.what.ariaLabel!, this.what);
    this.cancel.onclick = () => this.dialog.close();
    const form = element("form", { autocomplete: "off" }, title, what, this.explanation, this.patient.root);
    form.append(this.state, this.problem);
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

  open(sendable: Sendable): void {
    this.sendable = sendable;
    this.what.value = "picture";
    this.volume.disabled = sendable.volume === undefined;
    this.explain();
    sendable.picture.catch((error: Error) => (this.problem.textContent = error.message));
    this.problem.textContent = "";
    this.state.textContent = "";
    this.dialog.showModal();
    void queueState().then((state) => state && this.tell(state));
  }

  private explain(): void {
    const hint = this.volume.disabled ? ` ${kFreezeFirst}` : "";
    this.explanation.textContent = kExplanations[this.what.value as What] + hint;
  }

  private tell({ waiting, refused }: QueueState): void {
    const parts = [];
    if (waiting > 0) parts.push(`${waiting} earlier ${waiting === 1 ? "item waits" : "items wait"} to be sent.`);
    if (refused > 0) parts.push(`The archive has refused ${refused}: ask the administrator.`);
    this.state.textContent = parts.join(" ");
  }

  /** While a still is under way the form stays: its answer must not meet the next one. */
  private setBusy(isBusy: boolean): void {
    this.isBusy = isBusy;
    for (const each of [this.send, this.cancel, this.button, this.what]) each.disabled = isBusy;
    this.problem.textContent = "";
    this.send.textContent = isBusy ? "Sending…" : "Send";
  }

  /** What is chosen, as the server takes it. */
  private async object({ picture, loss, volume }: Sendable): Promise<object> {
    if (this.what.value === "volume") return { volume: Number(volume) };
    if (this.what.value === "picture") return { png: await textOf(await picture), ...(loss && { lossy: loss }) };
    const left = (seconds: number) => (this.send.textContent = `Recording, ${seconds} s left…`);
    const { jpegs, perSecond } = await recordClip(this.events.frame, left);
    this.send.textContent = "Sending…";
    return { jpegs: await Promise.all(jpegs.map(textOf)), pictures_per_second: perSecond };
  }

  private async submit(): Promise<void> {
    const patient = this.patient.patient();
    if (!patient || !this.sendable) return;
    const what = kNames[this.what.value as What];
    this.setBusy(true);
    try {
      const object = await this.object(this.sendable);
      await callApi("api/archive", { ...object, patient });
      this.dialog.close();
      this.events.sent(`The ${what} waits in the queue for the archive.`);
    } catch (error) {
      const sentence =
        error instanceof TypeError // of fetch()
          ? `The connection was lost: it is not known whether the ${what} was sent.`
          : `The ${what} was not sent: ${(error as Error).message}`;
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

/** In base64. */
function textOf(blob: Blob): Promise<string> {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve((reader.result as string).replace(/^[^,]*,/, ""));
    reader.onerror = () => reject(new Error("the browser cannot read the picture"));
    reader.readAsDataURL(blob);
  });
}
