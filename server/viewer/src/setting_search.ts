// SPDX-License-Identifier: Apache-2.0
// Finds settings by their words: rows and groups without them are hidden.

export function connectSearch(input: HTMLInputElement, form: HTMLFormElement, none: HTMLElement): void {
  let openBefore: Set<Element> | undefined; // the groups that the user had opened
  const search = (): void => {
    const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    const groups = [...form.querySelectorAll<HTMLDetailsElement>("details.group")];
    if (words.length > 0) openBefore ??= new Set(groups.filter((group) => group.open));
    const has = (text: string | null) => words.every((word) => (text ?? "").toLowerCase().includes(word));
    let found = 0;
    for (const section of form.querySelectorAll<HTMLElement>("details.group, section.main")) {
      const title = section.querySelector("h2")?.textContent ?? "";
      let shown = 0;
      for (const row of section.querySelectorAll<HTMLElement>(".row")) {
        const match = has(`${title} ${row.textContent}`);
        row.classList.toggle("not-found", !match);
        if (match) ++shown;
      }
      section.classList.toggle("not-found", words.length > 0 && shown === 0);
      found += shown;
    }
    for (const group of groups) {
      if (words.length > 0) group.open = !group.classList.contains("not-found");
      else if (openBefore) group.open = openBefore.has(group);
    }
    if (words.length === 0) openBefore = undefined;
    none.hidden = words.length === 0 || found > 0;
  };
  input.oninput = search;
}
