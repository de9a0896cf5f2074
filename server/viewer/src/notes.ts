// SPDX-License-Identifier: Apache-2.0
/** Lists what is assumed of the source, or was noticed about it, a sentence each. */
export function listNotes(list: HTMLElement, notes: string[]): void {
  list.replaceChildren(
    ...notes.map((note) => {
      const item = document.createElement("li");
      item.textContent = note;
      return item;
    }),
  );
}
