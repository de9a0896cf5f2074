// SPDX-License-Identifier: Apache-2.0
// A message beside the picture, in one line. Where it is longer, "Details" shows all of it; a button closes it.
import { element, find } from "./element";

/** `closed`: the user has closed it; it is hidden already. */
export function makeBanner(root: HTMLElement, closed: () => void): void {
  const details = element("button", { type: "button", className: "details", ariaExpanded: "false" });
  details.setAttribute("aria-label", "Details");
  const close = element("button", { type: "button", className: "close" });
  close.setAttribute("aria-label", "Close this message");
  root.classList.add("banner");
  root.append(details, close);
  const open = (opened: boolean) => {
    root.classList.toggle("open", opened);
    details.ariaExpanded = String(opened);
  };
  const text = details.previousElementSibling as HTMLElement;
  const measure = () => {
    const isLong = text.scrollWidth > text.clientWidth + 1;
    if (!root.classList.contains("open")) details.hidden = !isLong;
  };
  details.onclick = () => open(!root.classList.contains("open"));
  close.onclick = () => {
    root.hidden = true;
    open(false);
    closed();
  };
  new ResizeObserver(measure).observe(text);
  new MutationObserver(measure).observe(text, { childList: true, characterData: true, subtree: true });
}

/** Makes the element a banner with a child for the sentence; what shows one there, or nothing where it is empty. */
export function bannerAt(selector: string): (sentence: string) => void {
  const root = find(selector, HTMLElement);
  makeBanner(root, () => undefined);
  return (sentence) => {
    root.firstElementChild!.textContent = sentence;
    root.hidden = sentence === "";
  };
}
