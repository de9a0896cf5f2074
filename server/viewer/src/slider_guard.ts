// SPDX-License-Identifier: Apache-2.0
// On a touch screen, a scroll that begins on a slider must not move it: the slider takes a tap, or a drag along it.

const kDragPixels = 8;

interface Touch {
  slider: HTMLInputElement;
  value: string; // before the touch
  wanted: string | undefined; // that the touch has set; what follows the server may overwrite it meanwhile
  x: number;
  y: number;
}

/** Call it before the sliders of `root` are made: it catches their events first. */
export function guardSliders(root: HTMLElement): void {
  let undecided: Touch | undefined;
  const isSlider = (target: EventTarget | null): target is HTMLInputElement =>
    target instanceof HTMLInputElement && target.type === "range";
  const begins = (): void => {
    const touch = undecided;
    undecided = undefined;
    if (!touch || touch.wanted === undefined) return;
    touch.slider.value = touch.wanted;
    touch.slider.dispatchEvent(new Event("input", { bubbles: true }));
  };

  root.addEventListener(
    "pointerdown",
    ({ target, pointerType, clientX: x, clientY: y }) => {
      undecided =
        pointerType === "touch" && isSlider(target)
          ? { slider: target, value: target.value, wanted: undefined, x, y }
          : undefined;
    },
    true,
  );
  root.addEventListener(
    "pointermove",
    ({ clientX, clientY }) => {
      if (!undecided) return;
      const [across, down] = [Math.abs(clientX - undecided.x), Math.abs(clientY - undecided.y)];
      if (across >= kDragPixels && across > down) begins();
    },
    true,
  );
  root.addEventListener("pointerup", begins, true);
  root.addEventListener(
    "pointercancel",
    () => {
      if (undecided) undecided.slider.value = undecided.value;
      undecided = undefined;
    },
    true,
  );
  for (const type of ["input", "change"]) {
    root.addEventListener(
      type,
      (event) => {
        if (!undecided || event.target !== undecided.slider) return;
        undecided.wanted = undecided.slider.value;
        event.stopImmediatePropagation();
      },
      true,
    );
  }
}
