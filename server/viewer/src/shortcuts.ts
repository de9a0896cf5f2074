// SPDX-License-Identifier: Apache-2.0
// The keys of the page, as its buttons' tooltips name them.
import type { CineBar } from "./cine_bar";
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

export function connectShortcuts({ cineBar, quickPanel, tools, overlay, shell }: ShortcutTargets): void {
  releaseClicked(document.body);
  connectKeys(document.body, {
    " ": () => cineBar.toggle(),
    ",": () => cineBar.step(-1),
    ".": () => cineBar.step(1),
    k: () => cineBar.playOrPause(),
    "1": () => quickPanel.choosePanes("surface"),
    "2": () => quickPanel.choosePanes("surface-and-volume"),
    "4": () => quickPanel.choosePanes("slices"),
    l: () => tools.choose("light"),
    t: () => tools.choose("orbit"),
    p: () => tools.choose("pan"),
    m: () => tools.choose("measure"),
    c: () => tools.choose("crop"),
    n: () => tools.choose("note"),
    s: () => overlay.still(),
    v: () => overlay.clip.toggle(),
    z: () => quickPanel.undo(),
    "ctrl+z": () => quickPanel.undo(),
    y: () => quickPanel.redo(),
    "ctrl+shift+z": () => quickPanel.redo(),
    "ctrl+y": () => quickPanel.redo(),
    f: () => shell.toggleFullScreen(),
    i: () => shell.toggleStatistics(),
  });
}
