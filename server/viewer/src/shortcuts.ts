// SPDX-License-Identifier: Apache-2.0
// The keys of the page, as its buttons' tooltips name them, and the list of them that ? shows.
import type { CineBar } from "./cine_bar";
import { element } from "./element";
import { connectKeys, releaseClicked } from "./keys";
import type { PageShell } from "./page_shell";
import type { PictureOverlay } from "./picture_overlay";
import type { QuickPanel } from "./quick_panel";
import type { Tools } from "./tools";

export interface ShortcutTargets {
  cineBar: CineBar;
  quickPanel: QuickPanel;
  tools: Tools;
  overlay: PictureOverlay;
  shell: PageShell;
}

/** The keys of one action, as connectKeys() names them, what they do, and the action. */
type Row = readonly [keys: readonly string[], text: string, act: () => void];

/** Keys over the picture, which PictureInput carries out. */
const kPictureKeys: readonly (readonly [string, string])[] = [
  ["← → ↑ ↓", "Move the light; the camera with Turn or Pan; the cross with Measure, Scalpel or Note"],
  ["Enter", "Set a point with Measure, a corner or a ball with Scalpel, a note with Note"],
  ["Escape", "Give up a measurement or a lasso that was begun"],
  ["Tab, then ← → ↑ ↓", "Choose a line, a handle or a side of the crop box, and move it"],
  ["Page Up, Page Down", "Move the light nearer, farther"],
  ["+ −", "Zoom"],
  ["Home", "Reset the view"],
];

export function connectShortcuts({ cineBar, quickPanel, tools, overlay, shell }: ShortcutTargets): void {
  const list = element("dialog", { id: "shortcuts" });
  const rows: Row[] = [
    [[" "], "Freeze, or live again", () => cineBar.toggle()],
    [[","], "Previous volume", () => cineBar.step(-1)],
    [["."], "Next volume", () => cineBar.step(1)],
    [["k"], "Play the last volumes, or pause", () => cineBar.playOrPause()],
    [["1"], "One pane: the surface", () => quickPanel.choosePanes("surface")],
    [["2"], "Two panes: surface and volume", () => quickPanel.choosePanes("surface-and-volume")],
    [["4"], "Four panes: planes and surface", () => quickPanel.choosePanes("slices")],
    [["9"], "Nine parallel planes", () => quickPanel.choosePanes("tomography")],
    [["l"], "Light", () => tools.choose("light")],
    [["t"], "Turn", () => tools.choose("orbit")],
    [["p"], "Pan", () => tools.choose("pan")],
    [["m"], "Measure", () => tools.choose("measure")],
    [["c"], "Crop", () => tools.choose("crop")],
    [["x"], "Scalpel", () => tools.choose("cut")],
    [["n"], "Note", () => tools.choose("note")],
    [["s"], "Save a still", () => overlay.still()],
    [["v"], "Start or end a clip", () => overlay.clip.toggle()],
    [["z", "ctrl+z"], "Undo", () => quickPanel.undo()],
    [["y", "ctrl+y", "ctrl+shift+z"], "Redo", () => quickPanel.redo()],
    [["f"], "Full screen", () => shell.toggleFullScreen()],
    [["i"], "Statistics", () => shell.toggleStatistics()],
    [["?"], "Show these shortcuts", () => open(list)],
  ];
  const texts = rows.map(([keys, text]) => [keys.map(nameOf).join(", "), text] as const);
  const button = element("button", { textContent: "Close" });
  const form = element("form", { method: "dialog" });
  form.append(button);
  list.append(element("h2", { textContent: "Keyboard shortcuts" }), tableOf([...texts, ...kPictureKeys]), form);
  document.body.append(list);
  releaseClicked(document.body);
  connectKeys(document.body, Object.fromEntries(rows.flatMap(([keys, , act]) => keys.map((key) => [key, act]))));
}

/** At its top: the button that gets the focus is below the list. */
function open(list: HTMLDialogElement): void {
  list.showModal();
  list.scrollTop = 0;
}

/** "Ctrl+Shift+Z" */
function nameOf(key: string): string {
  if (key === " ") return "Space";
  return key.replace(/[a-z]+/g, (word) => word[0]!.toUpperCase() + word.slice(1));
}

function tableOf(rows: readonly (readonly [string, string])[]): HTMLElement {
  const table = element("dl", {});
  for (const [keys, text] of rows)
    table.append(element("dt", { textContent: keys }), element("dd", { textContent: text }));
  return table;
}
