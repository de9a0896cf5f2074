// SPDX-License-Identifier: Apache-2.0
// The form that sends a still, a clip or a volume to the hospital's archive. Loaded when it is first opened (archive_button.ts).
import { callApi } from "./api";
import type { ArchiveEvents, Loss } from "./archive_button";
import { kClipS, kPerSecond, recordClip } from "./archive_clip";
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
  clip: `Closes this form, records what this display shows for ${kClipS} s, and sends it.`,
  volume:
    "Sends the echoes of the frozen volume, which other programs can slice and render. Measurements and notes are not in it.",
};
const kNames: Record<What, string> = { picture: "still", clip: "clip", volume: "volume" };

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
    this.volume.textContent = this.volume.disabled ? "Volume (freeze the picture first)" : "Frozen volume";
    this.explain();
    sendable.picture.catch((error: Error) => (this.problem.textContent = error.message));
    this.problem.textContent = "";
    this.state.textContent = "";
    this.dialog.showModal();
    void queueState().then((state) => state && this.tell(state));
  }

  private explain(): void {
    this.explanation.textContent = kExplanations[this.what.value as What];
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
    if (isBusy) this.problem.textContent = "";
    this.send.textContent = isBusy ? "Sending…" : "Send";
    if (!isBusy) this.button.textContent = "Send";
  }

  private async submit(): Promise<void> {
    const patient = this.patient.patient();
    if (!patient || !this.sendable) return;
    const what = this.what.value as What;
    this.setBusy(true);
    if (what === "clip") this.dialog.close(); // the picture can be seen and used
    let isPosted = false;
    try {
      const object = await this.object(what, this.sendable);
      if (this.button.hidden) throw new Error("this display may not send any more.");
      isPosted = true;
      await callApi("api/archive", { ...object, patient });
      this.dialog.close();
      const length = "jpegs" in object ? ` of ${(object.jpegs.length / kPerSecond).toFixed(1)} s` : "";
      this.events.sent(`The ${kNames[what]}${length} waits in the queue for the archive.`);
    } catch (error) {
      const isLost = isPosted && error instanceof TypeError; // of fetch()
      this.fail(
        isLost
          ? `The connection was lost: it is not known whether the ${kNames[what]} was sent.`
          : `The ${kNames[what]} was not sent: ${(error as Error).message}`,
      );
    } finally {
      this.setBusy(false);
    }
  }

  /** What is chosen, as the server takes it. */
  private async object(what: What, { picture, loss, volume }: Sendable): Promise<{ jpegs: string[] } | object> {
    if (what === "volume") return { volume: Number(volume) };
    if (what === "picture") return { png: await textOf(await picture), ...(loss && { lossy: loss }) };
    const jpegs = await recordClip(this.events.frame, (left) => (this.button.textContent = `Recording, ${left} s`));
    this.button.textContent = "Sending…";
    return { jpegs: await Promise.all(jpegs.map(textOf)), pictures_per_second: kPerSecond };
  }

  private fail(sentence: string): void {
    if (this.dialog.open) this.problem.textContent = sentence;
    else this.events.failed(sentence);
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
