// SPDX-License-Identifier: Apache-2.0
// Finds settings by their words, or by those of other scanners: rows and groups without them are hidden.

/** What scanners and other programs call it: the words by which it is found here. */
const kSynonyms: Readonly<Record<string, string>> = {
  invert: "sign",
  inversion: "sign",
  gain: "threshold",
  cutoff: "threshold",
  eraser: "scalpel",
  cut: "scalpel",
  knife: "scalpel",
  magicut: "scalpel",
  transparency: "opacity",
  transparent: "opacity",
  silhouette: "glass",
  brightness: "exposure",
  contrast: "exposure",
  zoom: "field",
  magnification: "field",
  rotate: "yaw",
  rotation: "yaw",
  tilt: "pitch",
  smooth: "filter",
  smoothing: "filter",
  denoise: "speckle",
  noise: "speckle",
  persistence: "steady",
  average: "steady",
  resolution: "step",
  quality: "picture rate",
  palette: "colours",
  tint: "colours",
  colour: "colours",
  color: "colours",
  lamp: "light",
  shading: "shadow",
};

export function connectSearch(input: HTMLInputElement, form: HTMLFormElement, none: HTMLElement): void {
  let openBefore: Set<Element> | undefined; // the groups that the user had opened
  const search = (): void => {
    const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    const groups = [...form.querySelectorAll<HTMLDetailsElement>("details.group")];
    if (words.length > 0) openBefore ??= new Set(groups.filter((group) => group.open));
    const texts = [...form.querySelectorAll(".row")].map((row) => row.textContent?.toLowerCase() ?? "");
    // A synonym counts where no setting has the word itself.
    const known = words.map((word) => (texts.some((text) => text.includes(word)) ? word : (synonymOf(word) ?? word)));
    const has = (text: string | null) => known.every((word) => (text ?? "").toLowerCase().includes(word));
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

/** Also of the beginning of a word, while it is typed. */
function synonymOf(word: string): string | undefined {
  if (word.length < 3) return undefined;
  return kSynonyms[word] ?? Object.entries(kSynonyms).find(([known]) => known.startsWith(word))?.[1];
}
