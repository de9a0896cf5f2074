// SPDX-License-Identifier: Apache-2.0
// Notes: texts that stand at a place of the picture on this display, and on its stills.
import { element } from "./element";
import type { PagePoint } from "./view_geometry";

const kMostNotes = 20;
const kLongestNote = 60;

export interface PictureNote {
  text: string;
  /** Shares of the picture's width and height. */
  x: number;
  y: number;
}

export function isOnTheRight(note: PictureNote): boolean {
  return note.x > 0.5;
}

export class PictureNotes {
  private notes: PictureNote[] = [];
  private chosen = false;

  constructor(
    private readonly root: HTMLElement,
    private readonly frame: HTMLElement,
    private readonly failed: (sentence: string) => void,
  ) {}

  all(): readonly PictureNote[] {
    return this.notes;
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
    const note = { text: "", x: (pointer.x - shown.left) / shown.width, y: (pointer.y - shown.top) / shown.height };
    this.notes = [...this.notes, note];
    this.edit(note);
  }

  /** An input in place of the note. An empty text removes it. */
  private edit(note: PictureNote): void {
    const before = note.text;
    const input = element("input", { type: "text", value: before, maxLength: kLongestNote, ariaLabel: "Note" });
    this.draw(note, input);
    let ended = false;
    const end = (text: string) => {
      if (ended) return;
      ended = true;
      note.text = text.trim();
      this.notes = this.notes.filter((each) => each.text !== "");
      this.draw();
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
    this.root.replaceChildren(
      ...this.notes.map((note) => {
        const part = note === edited && input ? input : this.label(note);
        // In the right half it ends where it was clicked, so that it stays on the picture.
        if (isOnTheRight(note)) part.style.right = `${100 * (1 - note.x)}%`;
        else part.style.left = `${100 * note.x}%`;
        part.style.top = `${100 * note.y}%`;
        return part;
      }),
    );
  }

  private label(note: PictureNote): HTMLElement {
    if (!this.chosen) return element("span", { textContent: note.text });
    const button = element("button", { type: "button", textContent: note.text, title: "Change or remove this note" });
    button.onclick = () => this.edit(note);
    return button;
  }
}
