// SPDX-License-Identifier: Apache-2.0
// Finds and creates HTML and SVG elements.

export function find<Kind extends Element>(selector: string, kind: new () => Kind): Kind {
  const found = document.querySelector(selector);
  if (!(found instanceof kind)) throw new Error(`The page has no ${selector}.`);
  return found;
}

export function element<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  properties: Partial<HTMLElementTagNameMap[Tag]>,
  ...children: (Node | string)[]
): HTMLElementTagNameMap[Tag] {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

export function drawing<Tag extends keyof SVGElementTagNameMap>(
  tag: Tag,
  attributes: Record<string, string | number>,
  ...children: (Node | string)[]
): SVGElementTagNameMap[Tag] {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  setAttributes(made, attributes);
  made.append(...children);
  return made;
}

export function setAttributes(of: Element, attributes: Record<string, string | number>): void {
  for (const [name, value] of Object.entries(attributes)) of.setAttribute(name, String(value));
}

/**
 * Typed text is taken when the box loses the focus or Enter is pressed. It is not overwritten before.
 * Returns a function that shows `text()` in the box, unless the user is typing.
 */
export function typedBox(input: HTMLInputElement, text: () => string, take: () => void): () => void {
  let typing = false;
  const show = () => {
    if (!typing && input.value !== text()) input.value = text();
  };
  input.oninput = () => {
    typing = true;
  };
  input.onchange = () => {
    typing = false;
    take();
    show();
  };
  // Text that was typed and then restored causes no change event, but the box may be overwritten again.
  input.onblur = () => {
    typing = false;
    show();
  };
  return show;
}
