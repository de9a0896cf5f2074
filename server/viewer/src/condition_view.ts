// SPDX-License-Identifier: Apache-2.0
// Shows what holds of the connection and the picture: the word in the header, the marks on the picture, the notice.
import type { Picture } from "../generated/fanlight_pb.js";
import { makeBanner } from "./banner";
import { ageText, markText, stateWord } from "./liveness";
import { noticeFor, type Condition } from "./notice";

const kRenderingMs = 500; // a change that is shown sooner needs no word

/** Why the picture is only a preview: this display has turned it, or the server has cast it coarsely. */
export type Preview = "turned" | "coarse";

const kPreviewTitles: Record<Preview, string> = {
  turned: "Turned by this display. What it cannot know is grey.",
  coarse: "Coarse while it changes.",
};
const kMostMovingLevel = 1; // of the deadline plan: from the next one on, pictures are coarse at rest too

export function previewOf(
  shown: Pick<Picture, "deadlineLevel" | "measures"> | undefined,
  isTurned: boolean,
): Preview | undefined {
  if (isTurned) return "turned";
  const isCoarse = shown?.measures.includes("coarse picture") && shown.deadlineLevel <= kMostMovingLevel;
  return isCoarse ? "coarse" : undefined;
}

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
  private preview: Preview | undefined;
  private busySinceMs: number | undefined; // since when the picture lacks a change

  private closedTitle = ""; // of the notice that the user has closed

  constructor(private readonly places: ConditionPlaces) {
    makeBanner(places.notice, () => (this.closedTitle = places.notice.firstElementChild!.textContent ?? ""));
  }

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
    const isWanted = isOpen && pictureShown && ["replay", "ended", "frozen"].includes(liveness.state);
    frame.classList.toggle("stale", !isLive && !isWanted);
    notLive.hidden = isLive;
    write(notLive, markText(isOpen ? liveness : { ...liveness, state: "not-live" }));
    notLive.title = liveness.detail;
    this.showNotice(condition);
  }

  /** Whether the picture lacks a change that was asked for, and whether it is a preview only. */
  setBusy(busy: boolean, preview: Preview | undefined, nowMs: number): void {
    this.busySinceMs = busy ? (this.busySinceMs ?? nowMs) : undefined;
    this.preview = preview;
  }

  /**
   * Says that a change is on its way where that takes long, and at once that this display has turned the picture;
   * nothing where no picture can come at all.
   */
  showRendering({ pictureShown, connection }: Condition, nowMs: number): void {
    const { rendering } = this.places;
    const long = this.busySinceMs !== undefined && nowMs - this.busySinceMs > kRenderingMs;
    rendering.hidden = !(long || this.preview) || !pictureShown || connection.state !== "open";
    const preview = long && this.preview === "coarse" ? undefined : this.preview;
    write(rendering, preview ? "Preview …" : "Rendering …");
    rendering.title = preview ? kPreviewTitles[preview] : "";
  }

  private showNotice(condition: Condition): void {
    const { notice } = this.places;
    const text = noticeFor(condition);
    if (text?.title !== this.closedTitle) this.closedTitle = "";
    notice.hidden = !text || text.title === this.closedTitle;
    notice.dataset.kind = text?.kind ?? "";
    const [title, detail] = notice.children;
    write(title!, text?.title ?? "");
    write(detail!, text?.detail ?? "");
  }
}

/** Writes only changed text, because a screen reader announces every write. */
function write(place: Element, text: string): void {
  if (place.textContent !== text) place.textContent = text;
}
