// SPDX-License-Identifier: Apache-2.0
import { makeBanner } from "./banner";
import { element } from "./element";

/** Lists what is assumed of the source, or was noticed about it, a sentence each, until it is closed. */
export function listNotes(list: HTMLElement, notes: string[]): void {
  list.replaceChildren(
    ...notes.map((note) => {
      const item = element("li", {});
      item.append(element("span", { textContent: note }));
      makeBanner(item, () => item.remove());
      return item;
    }),
  );
}
