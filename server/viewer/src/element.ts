// Making what the page is made of.

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
 * What is typed into the box counts when it is left or entered, and is not overwritten before.
 * Returns what shows the text it should have.
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
  // Typed and taken back is no change, but the box is free again.
  input.onblur = () => {
    typing = false;
    show();
  };
  return show;
}
