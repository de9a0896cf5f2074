// SPDX-License-Identifier: Apache-2.0
// The transfer function as a curve of opacity over grey level, with points to drag, and the colours below it. The axis
// shows the square root of the opacity, because useful opacities are a few hundredths per mm.
import { drawing, element, setAttributes, typedBox } from "./element";
import {
  added,
  addedInGap,
  formatPoints,
  kMostLevel,
  kMostOpacity,
  kMostPoints,
  moved,
  parsePoints,
  pointAt,
  recoloured,
  removed,
  type TransferPoint,
} from "./transfer_points";

const kWidth = 300;
const kHeight = 150;
const kPlot = { left: 26, right: 290, top: 10, bottom: 112 };
const kStripHeight = 12;
const kOpacityLines = [0.01, 0.1, 0.3, 0.6, 1];
const kLevelTicks = [0, 64, 128, 192, 255];
const kLevelNudge = 1;
const kOpacityNudge = 0.01;
const kLargeNudge = 10; // factor while Shift is held

export class TransferEditor {
  readonly root: HTMLElement;

  private points: TransferPoint[] = [];
  private chosen = 0;
  /** Offset from the point to the pointer at the start of the drag, in units of the drawing. */
  private hold: { x: number; y: number } | undefined;

  private readonly stops = drawing("linearGradient", { id: "transfer-colours" });
  private readonly area = drawing("path", { class: "area", fill: "url(#transfer-colours)" });
  private readonly curve = drawing("path", { class: "curve" });
  private readonly handles = drawing("g", {});
  private readonly plot: SVGSVGElement;

  private readonly title = element("span", { className: "title" });
  private readonly remove = element("button", { type: "button", textContent: "Remove" });
  private readonly add = element("button", { type: "button", textContent: "Add point" });
  private readonly colour = element("input", { type: "color" });
  private readonly showBoxes: (() => void)[];

  /** `change` is called with the new text after each change by the user. */
  constructor(private readonly change: (text: string) => void) {
    this.plot = this.makePlot();
    const level = this.numberBox("level", kMostLevel, 1, (point) => String(point.level));
    const opacity = this.numberBox("opacity", kMostOpacity, 0.001, (point) => String(point.opacity));
    const place = () => this.place(level.input.valueAsNumber, opacity.input.valueAsNumber);
    this.showBoxes = [typedBox(level.input, level.text, place), typedBox(opacity.input, opacity.text, place)];
    this.colour.dataset.point = "colour";
    this.colour.setAttribute("aria-label", "Colour of the point");
    this.colour.oninput = () => this.take(recoloured(this.points, this.chosen, this.colour.value));
    this.remove.dataset.point = "remove";
    this.remove.onclick = () => this.removeChosen();
    this.add.dataset.point = "add";
    this.add.onclick = () => this.takeAdded(addedInGap(this.points));
    this.root = element(
      "div",
      { className: "transfer" },
      this.plot,
      element("div", { className: "point" }, this.title, this.colour, this.remove, this.add),
      element(
        "div",
        { className: "point" },
        element("label", {}, "Grey level", level.input),
        element("label", {}, "Opacity per mm", opacity.input),
      ),
    );
  }

  /** An invalid text leaves the curve unchanged. */
  show(text: string): void {
    this.points = parsePoints(text) ?? this.points;
    if (this.points.length === 0) return;
    this.chosen = Math.min(this.chosen, this.points.length - 1);
    this.draw();
  }

  private numberBox(name: string, most: number, step: number, text: (point: TransferPoint) => string) {
    const input = element("input", { type: "number", min: "0", max: String(most), step: String(step) });
    input.dataset.point = name;
    const chosenText = () => {
      const point = this.points[this.chosen];
      return point ? text(point) : "";
    };
    return { input, text: chosenText };
  }

  private makePlot(): SVGSVGElement {
    const { left, right, top, bottom } = kPlot;
    const grid = drawing("g", { class: "grid" });
    for (const opacity of kOpacityLines) {
      const y = yOf(opacity);
      grid.append(drawing("path", { d: `M${left} ${y}H${right}` }));
      grid.append(drawing("text", { x: left - 4, y: y + 3, "text-anchor": "end" }, String(opacity)));
    }
    for (const level of kLevelTicks) {
      grid.append(drawing("text", { x: xOf(level), y: kHeight - 8, "text-anchor": "middle" }, String(level)));
    }
    grid.append(drawing("path", { d: `M${left} ${bottom}H${right}` }));
    const strip = { x: left, y: bottom + 6, width: right - left, height: kStripHeight, fill: "url(#transfer-colours)" };
    const ground = { class: "ground", x: left, y: top, width: right - left, height: bottom - top };
    const plot = drawing(
      "svg",
      { viewBox: `0 0 ${kWidth} ${kHeight}`, role: "group", "aria-label": "Opacity and colour by grey level" },
      drawing("defs", {}, this.stops),
      drawing("rect", ground),
      this.area,
      grid,
      drawing("rect", strip),
      this.curve,
      this.handles,
    );
    plot.ondblclick = (event) => {
      const { x, y } = this.inPlot(event);
      this.takeAdded(added(this.points, levelAt(x), opacityAt(y)));
    };
    return plot;
  }

  private makeHandle(index: number): SVGGElement {
    const handle = drawing("g", { class: "handle", tabindex: 0, role: "slider", "data-handle": index });
    handle.append(drawing("circle", { class: "reach", r: 13 }), drawing("circle", { class: "knob", r: 5.5 }));
    setAttributes(handle, { "aria-valuemin": 0, "aria-valuemax": kMostLevel });
    handle.onfocus = () => this.choose(index);
    handle.onpointerdown = (event) => {
      const { x, y } = this.inPlot(event);
      const point = this.points[index];
      if (event.button !== 0 || !point) return;
      handle.setPointerCapture(event.pointerId);
      handle.focus({ preventScroll: true });
      this.choose(index);
      this.hold = { x: x - xOf(point.level), y: y - yOf(point.opacity) };
      event.preventDefault();
    };
    handle.onpointermove = (event) => {
      if (!this.hold || !handle.hasPointerCapture(event.pointerId)) return;
      const { x, y } = this.inPlot(event);
      this.take(moved(this.points, index, levelAt(x - this.hold.x), opacityAt(y - this.hold.y)));
    };
    handle.onpointerup = handle.onpointercancel = () => {
      this.hold = undefined;
    };
    handle.ondblclick = (event) => event.stopPropagation();
    handle.onkeydown = (event) => this.typed(event);
    return handle;
  }

  private typed(event: KeyboardEvent): void {
    const point = this.points[this.chosen];
    if (!point || event.ctrlKey || event.metaKey || event.altKey) return;
    const far = event.shiftKey ? kLargeNudge : 1;
    const nudge = (levels: number, opacities: number) =>
      this.place(point.level + levels * far * kLevelNudge, point.opacity + opacities * far * kOpacityNudge);
    const keys: Record<string, () => void> = {
      ArrowLeft: () => nudge(-1, 0),
      ArrowRight: () => nudge(1, 0),
      ArrowUp: () => nudge(0, 1),
      ArrowDown: () => nudge(0, -1),
      Delete: () => this.removeChosen(),
    };
    const act = keys[event.key];
    if (!act) return;
    act();
    event.preventDefault();
  }

  private choose(index: number): void {
    this.chosen = index;
    this.draw();
  }

  private place(level: number, opacity: number): void {
    if (Number.isFinite(level) && Number.isFinite(opacity)) this.take(moved(this.points, this.chosen, level, opacity));
  }

  private removeChosen(): void {
    const hadFocus = this.handles.contains(document.activeElement);
    this.take(removed(this.points, this.chosen));
    if (hadFocus) this.focusChosen();
  }

  private takeAdded(more: ReturnType<typeof added>): void {
    if (!more) return;
    this.chosen = more.index;
    this.take(more.points);
    this.focusChosen();
  }

  private focusChosen(): void {
    (this.handles.children[this.chosen] as SVGGElement | undefined)?.focus({ preventScroll: true });
  }

  private take(points: TransferPoint[]): void {
    this.change(formatPoints(points));
  }

  private draw(): void {
    const { points, chosen } = this;
    this.stops.replaceChildren(...points.map(({ level, colour }) => colourStop(level / kMostLevel, colour)));
    const line = curveOf(points);
    this.curve.setAttribute("d", line);
    this.area.setAttribute("d", `${line}V${kPlot.bottom}H${kPlot.left}Z`);
    this.drawHandles();
    this.title.textContent = `Point ${chosen + 1} of ${points.length}`;
    this.colour.value = points[chosen]?.colour ?? "#000000";
    this.remove.disabled = points.length === 1;
    this.add.disabled = points.length === kMostPoints;
    for (const show of this.showBoxes) show();
  }

  private drawHandles(): void {
    while (this.handles.childElementCount > this.points.length) this.handles.lastElementChild?.remove();
    this.points.forEach(({ level, colour, opacity }, index) => {
      const handle = this.handles.children[index] ?? this.handles.appendChild(this.makeHandle(index));
      handle.classList.toggle("chosen", index === this.chosen);
      setAttributes(handle, {
        transform: `translate(${xOf(level)} ${yOf(opacity)})`,
        "aria-label": `Point ${index + 1} of ${this.points.length}`,
        "aria-valuenow": level,
        "aria-valuetext": `grey level ${level}, opacity ${opacity} per mm, colour ${colour}`,
      });
      handle.lastElementChild?.setAttribute("fill", colour);
    });
  }

  private inPlot(event: MouseEvent): { x: number; y: number } {
    const shown = this.plot.getBoundingClientRect();
    return {
      x: ((event.clientX - shown.left) * kWidth) / shown.width,
      y: ((event.clientY - shown.top) * kHeight) / shown.height,
    };
  }
}

/** Opacity is linear between points, so its square root is drawn as a curve. */
function curveOf(points: readonly TransferPoint[]): string {
  const levels = Array.from({ length: kMostLevel + 1 }, (_, level) => level);
  const places = levels.map((level) => `${xOf(level)} ${yOf(pointAt(points, level).opacity)}`);
  return `M${places.join("L")}`;
}

function colourStop(offset: number, colour: string): SVGStopElement {
  return drawing("stop", { offset: offset.toFixed(4), "stop-color": colour });
}

function xOf(level: number): number {
  return tenth(kPlot.left + (level / kMostLevel) * (kPlot.right - kPlot.left));
}

function yOf(opacity: number): number {
  return tenth(kPlot.bottom - Math.sqrt(opacity) * (kPlot.bottom - kPlot.top));
}

function levelAt(x: number): number {
  return ((x - kPlot.left) / (kPlot.right - kPlot.left)) * kMostLevel;
}

function opacityAt(y: number): number {
  return Math.max(0, (kPlot.bottom - y) / (kPlot.bottom - kPlot.top)) ** 2;
}

function tenth(value: number): number {
  return Math.round(value * 10) / 10;
}
