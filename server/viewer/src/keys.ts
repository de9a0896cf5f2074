// SPDX-License-Identifier: Apache-2.0
// Keys of the whole page. They are ignored while the user types, and where the focused control uses the key itself.

export type KeyActions = Readonly<Record<string, () => void>>;

/** Names as in KeyboardEvent.key, in lower case; "ctrl+z" also stands for the Command key of a Mac. */
export function connectKeys(root: HTMLElement, actions: KeyActions): void {
  root.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.altKey || isTyping(event.target, event.key)) return;
    const held = event.ctrlKey || event.metaKey ? "ctrl+" : "";
    const act = actions[held + event.key.toLowerCase()];
    if (!act) return;
    act();
    event.preventDefault();
  });
}

function isTyping(target: EventTarget | null, key: string): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement && ["range", "radio", "checkbox"].includes(target.type)) return key === " ";
  const usesSpace = target instanceof HTMLButtonElement || target.tagName === "SUMMARY";
  if (usesSpace) return key === " " || key === "Enter";
  return target instanceof HTMLInputElement || target instanceof HTMLSelectElement;
}
