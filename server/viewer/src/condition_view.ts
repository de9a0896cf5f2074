// SPDX-License-Identifier: Apache-2.0
// Shows what holds of the connection and the picture: the word in the header, the marks on the picture, the notice.
import { ageText, markText, stateWord } from "./liveness";
import { noticeFor, type Condition } from "./notice";

const kRenderingMs = 500; // a change that is shown sooner needs no word

export interface ConditionPlaces {
  root: HTMLElement;
  /** Two children: the word, which screen readers announce, and the age, which changes too often for that. */
  connection: HTMLElement;
  frame: HTMLElement;
  notLive: HTMLElement;
  rendering: HTMLElement;
  /** Two children: title and detail. */
  notice: HTMLElement;
}

export class ConditionView {
  private busySinceMs: number | undefined; // since when the picture lacks a change

  constructor(private readonly places: ConditionPlaces) {}

  show(condition: Condition): void {
    const { root, connection, frame, notLive } = this.places;
    const { liveness, pictureShown } = condition;
    const state = condition.connection.state;
    const isOpen = state === "open";
    root.dataset.connection = state;
    root.dataset.picture = isOpen ? liveness.state : "not-live";
    const [word, age] = connection.children;
    write(word!, { connecting: "Connecting", open: stateWord(liveness), lost: "Lost" }[state]);
    write(age!, isOpen ? ageText(liveness.ageMs) : "");
    const isLive = isOpen && pictureShown && liveness.state === "live";
    const isWanted = isOpen && pictureShown && ["replay", "frozen"].includes(liveness.state);
    frame.classList.toggle("stale", !isLive && !isWanted);
    notLive.hidden = isLive;
    write(notLive, markText(isOpen ? liveness : { ...liveness, state: "not-live" }));
    this.showNotice(condition);
  }

  /** Whether the picture lacks a change that was asked for. */
  setBusy(busy: boolean, nowMs: number): void {
    this.busySinceMs = busy ? (this.busySinceMs ?? nowMs) : undefined;
  }

  /** Says that a change is on its way where that takes long; nothing where no picture can come at all. */
  showRendering({ pictureShown, connection }: Condition, nowMs: number): void {
    const long = this.busySinceMs !== undefined && nowMs - this.busySinceMs > kRenderingMs;
    this.places.rendering.hidden = !long || !pictureShown || connection.state !== "open";
  }

  private showNotice(condition: Condition): void {
    const { notice } = this.places;
    const text = noticeFor(condition);
    notice.hidden = !text;
    notice.dataset.kind = text?.kind ?? "";
    notice.classList.toggle("over-picture", condition.pictureShown);
    const [title, detail] = notice.children;
    write(title!, text?.title ?? "");
    write(detail!, text?.detail ?? "");
  }
}

/** Writes only changed text, because a screen reader announces every write. */
function write(place: Element, text: string): void {
  if (place.textContent !== text) place.textContent = text;
}
