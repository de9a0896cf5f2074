// SPDX-License-Identifier: Apache-2.0
// Notes: texts on this display and on its stills. One that was put on the surface stays at that point of the body while
// the view moves; another keeps its place in the picture.
import type { View } from "../generated/fanlight_pb.js";
import { element } from "./element";
import type { Mm } from "./measuring/figures";
import { pixelOfPoint } from "./measuring/surface_path";
import type { PagePoint, Size } from "./view_geometry";

const kMostNotes = 20;
const kLongestNote = 60;
const kBehindMm = 8; // deeper below the surface, a note is on its far side; a fetus moves by less

export interface PictureNote {
  text: string;
  /** Shares of the picture's width and height. */
  x: number;
  y: number;
  /** Whether the text ends at that place, so that it stays in the picture. Without: it begins there. */
  endsHere: boolean;
  /** In the transducer frame. */
  point?: Mm;
  /** It is on the far side of what is seen. */
  behind?: boolean;
}

/** The surface in shares of the picture's width and height; undefined where there is none, or it is not known. */
export type SurfaceAt = (place: PagePoint) => Mm | undefined;

export class PictureNotes {
  private notes: PictureNote[] = [];
  private chosen = false;
  private editing = false;
  private view: View | undefined;
  private size: Size = { width: 1, height: 1 }; // of the picture whose view it is
  private readonly parts = new Map<PictureNote, HTMLElement>(); // one stays, so that it can be clicked

  constructor(
    private readonly root: HTMLElement,
    private readonly frame: HTMLElement,
    private readonly surfaceAt: SurfaceAt,
    private readonly failed: (sentence: string) => void,
  ) {}

  /** Those that the picture shows. */
  all(): readonly PictureNote[] {
    return this.notes.filter(isInPicture);
  }

  /** The view of what is drawn now, in the pixels of a picture of that size; undefined: it shows no point of the body. */
  place(view: View | undefined, size: Size): void {
    [this.view, this.size] = [view, size];
    const anchored = this.notes.filter(({ point }) => point !== undefined);
    if (anchored.length === 0 || this.editing) return;
    for (const note of anchored) {
      const pixel = view && pixelOfPoint(note.point!, view);
      note.x = pixel ? (pixel.x + 0.5) / size.width : -1;
      note.y = pixel ? (pixel.y + 0.5) / size.height : -1;
      note.behind = this.isBehind(note) ?? note.behind ?? false;
      const part = this.parts.get(note);
      if (part) position(part, note);
    }
  }

  /** The tool was chosen, or left. */
  choose(chosen: boolean): void {
    this.chosen = chosen;
    this.root.classList.toggle("editing", chosen);
    this.draw();
  }

  clicked(pointer: PagePoint): void {
    if (this.notes.length >= kMostNotes) return this.failed(`There are ${kMostNotes} notes already: remove one first.`);
    const shown = this.frame.getBoundingClientRect();
    const place = { x: (pointer.x - shown.left) / shown.width, y: (pointer.y - shown.top) / shown.height };
    const point = this.surfaceAt(place);
    const note: PictureNote = { text: "", ...place, endsHere: place.x > 0.5, ...(point && { point }) };
    this.notes = [...this.notes, note];
    this.edit(note);
  }

  /** An input in place of the note. An empty text removes it. */
  private edit(note: PictureNote): void {
    const before = note.text;
    const input = element("input", { type: "text", value: before, maxLength: kLongestNote, ariaLabel: "Note" });
    this.draw(note, input);
    this.editing = true;
    let ended = false;
    const end = (text: string) => {
      if (ended) return;
      ended = true;
      this.editing = false;
      note.text = text.trim();
      this.notes = this.notes.filter((each) => each.text !== "");
      this.draw();
      this.place(this.view, this.size); // it may have moved meanwhile
    };
    input.onblur = () => end(input.value);
    input.onkeydown = (event) => {
      if (event.key === "Enter") end(input.value);
      if (event.key === "Escape") end(before);
      event.stopPropagation(); // letters are text here, not the page's keys
    };
    // The click that made the note still moves the focus after this.
    window.setTimeout(() => input.focus({ preventScroll: true }));
  }

  private draw(edited?: PictureNote, input?: HTMLInputElement): void {
    this.parts.clear();
    for (const note of this.notes) {
      const part = note === edited && input ? input : this.label(note);
      part.classList.toggle("ends-here", note.endsHere);
      part.classList.toggle("on-surface", note.point !== undefined);
      position(part, note);
      this.parts.set(note, part);
    }
    this.root.replaceChildren(...this.parts.values());
  }

  /** undefined where it is not known. */
  private isBehind(note: PictureNote): boolean | undefined {
    const seen = note.point && this.surfaceAt(note);
    const m = this.view?.matrix;
    if (!seen || !m) return undefined;
    const deeperMm = [2, 6, 10].reduce((sum, at, axis) => sum + m[at]! * (note.point![axis]! - seen[axis]!), 0);
    return deeperMm > kBehindMm;
  }

  private label(note: PictureNote): HTMLElement {
    if (!this.chosen) return element("span", { textContent: note.text });
    const button = element("button", { type: "button", textContent: note.text, title: "Change or remove this note" });
    button.onclick = () => this.edit(note);
    return button;
  }
}

function position(part: HTMLElement, note: PictureNote): void {
  if (note.endsHere) part.style.right = `${100 * (1 - note.x)}%`;
  else part.style.left = `${100 * note.x}%`;
  part.style.top = `${100 * note.y}%`;
  part.hidden = !isInPicture(note);
  part.classList.toggle("behind", note.behind === true);
}

function isInPicture({ x, y }: PictureNote): boolean {
  return x >= 0 && x <= 1 && y >= 0 && y <= 1;
}
