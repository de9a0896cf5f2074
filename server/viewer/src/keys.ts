// SPDX-License-Identifier: Apache-2.0
// Keys of the whole page. They are ignored while the user types, and where the focused control uses the key itself.

export type KeyActions = Readonly<Record<string, () => void>>;

/** A held key repeats these; the others switch something. */
const kRepeating = [",", ".", "z", "y", "ctrl+z", "ctrl+y", "ctrl+shift+z"];

/** Names as in KeyboardEvent.key, in lower case; "ctrl+z" also stands for the Command key of a Mac. */
export function connectKeys(root: HTMLElement, actions: KeyActions): void {
  root.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.altKey || isTyping(event.target, event.key)) return;
    const held = event.ctrlKey || event.metaKey ? (event.shiftKey ? "ctrl+shift+" : "ctrl+") : "";
    const key = held + event.key.toLowerCase();
    const act = actions[key];
    if (!act || (event.repeat && !kRepeating.includes(key))) return;
    act();
    event.preventDefault();
  });
}

/** A control that was clicked lets the focus go, so that Space means the page's Freeze and not the control again. */
export function releaseClicked(root: HTMLElement): void {
  let byPointer = false;
  root.addEventListener("pointerdown", () => (byPointer = true), true);
  root.addEventListener("keydown", () => (byPointer = false), true);
  root.addEventListener("click", () => {
    const focused = document.activeElement;
    if (
      byPointer &&
      focused instanceof HTMLElement &&
      focused.matches("button, summary, [type=radio], [type=checkbox]")
    )
      focused.blur();
  });
}

function isTyping(target: EventTarget | null, key: string): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement && target.type === "range") return false;
  if (target instanceof HTMLInputElement && ["radio", "checkbox"].includes(target.type)) return key === " ";
  const usesSpace = target instanceof HTMLButtonElement || target.tagName === "SUMMARY";
  if (usesSpace) return key === " " || key === "Enter";
  return target instanceof HTMLInputElement || target instanceof HTMLSelectElement;
}
