// SPDX-License-Identifier: Apache-2.0
// What one hand does on the page is one change, from its first finger down to its last one up.
import type { UndoHistory } from "./undo_history";

export function followHand(history: UndoHistory): void {
  const fingers = new Set<number>(); // on the page, by their pointer id; a mouse is one
  const lift = (event: PointerEvent) => {
    if (fingers.delete(event.pointerId) && fingers.size === 0) history.endGesture();
  };
  const liftAll = () => {
    fingers.clear();
    history.endGesture();
  };
  const press = (event: PointerEvent) => {
    if (event.isPrimary) liftAll(); // whatever is still noted has been lifted elsewhere
    // What was typed is taken when its box loses the focus, as a change of its own.
    const box = document.activeElement;
    if (box instanceof HTMLInputElement && box.type !== "range" && box !== event.target) box.blur();
    // The list of a <select> may swallow pointerup, and nothing is dragged in it.
    if (event.target instanceof HTMLSelectElement) return;
    fingers.add(event.pointerId);
    if (fingers.size === 1) history.beginGesture();
  };
  window.addEventListener("pointerdown", press, true);
  // A button acts after the hand has been lifted.
  for (const type of ["pointerup", "pointercancel"] as const) window.addEventListener(type, lift, true);
  window.addEventListener("blur", liftAll);
  // A menu of the browser swallows pointerup.
  window.addEventListener("contextmenu", (event) => {
    if (!event.defaultPrevented) liftAll();
  });
}
