// SPDX-License-Identifier: Apache-2.0
// What is measured, beside the picture; and the list of what was measured, in the panel.
import { element, find } from "../element";
import { planeThrough, type PlaneView } from "../plane_through";
import { saveFile, timeInName } from "../save_file";
import { figureText, kKinds, type Kind } from "./figures";
import { csvOf, kindTitle, type Measurement, type MeasurementList } from "./measurement_list";

const kForget = "Remove all";
const kReally = "Really remove all?";
const kAskedMs = 4000;

export interface MeasurePanelEvents {
  kindChosen(): void;
  /** The outline that is drawn is to be closed. */
  close(): void;
  takeBack(): void;
  wantVolume(): void;
  /** The plane through both points of a distance. */
  wantPlane(view: PlaneView): void;
  /** The list has changed. */
  changed(): void;
}

export class MeasurePanel {
  private mayMovePlanes = false;
  private shownKey = "";
  private readonly root = find("#measuring", HTMLFieldSetElement);
  private readonly kindBox = find("#measure-kind", HTMLSelectElement);
  private readonly close = find("#close-outline", HTMLButtonElement);
  private readonly takeBack = find("#take-back", HTMLButtonElement);
  private readonly section = find("#measurements", HTMLDetailsElement);
  private readonly items = find("#measurement-list", HTMLUListElement);
  private readonly forget = find("#forget-measurements", HTMLButtonElement);
  private readonly volume = find("#measure-volume", HTMLButtonElement);

  constructor(
    private readonly list: MeasurementList,
    private readonly events: MeasurePanelEvents,
  ) {
    this.kindBox.replaceChildren(
      ...Object.entries(kKinds).map(([value, { title }]) => element("option", { value, textContent: title })),
    );
    this.kindBox.onchange = () => events.kindChosen();
    this.close.onclick = () => events.close();
    this.takeBack.onclick = () => events.takeBack();
    this.volume.onclick = () => events.wantVolume();
    find("#save-measurements", HTMLButtonElement).onclick = () => this.save();
    this.forget.onclick = () => this.wantToForget();
  }

  kind(): Kind {
    return this.kindBox.value as Kind;
  }

  /** Whether this display may move the planes. */
  allowPlanes(may: boolean): void {
    this.mayMovePlanes = may;
  }

  show(isChosen: boolean): void {
    this.root.hidden = !isChosen;
  }

  /** How many points of the measurement there are that is under way. */
  underWay(points: number): void {
    this.takeBack.hidden = points === 0;
    this.close.hidden = this.kind() !== "area" || points < 3;
  }

  /** `volumeId`: of the picture. */
  showList(volumeId: bigint | undefined): void {
    const all = this.list.all();
    this.section.hidden = all.length === 0;
    this.volume.hidden = this.list.outlinesOf(volumeId).length < 3;
    const shown = this.list.of(volumeId);
    // An item stays while nothing changes: it may be about to be clicked.
    const key = [this.mayMovePlanes, ...all.map((each) => `${each.id} ${each.name} ${shown.includes(each)}`)].join();
    if (key === this.shownKey || this.items.contains(document.activeElement)) return; // a name is being typed
    this.shownKey = key;
    this.items.replaceChildren(...all.map((each) => this.item(each, shown.includes(each))));
  }

  private item(measurement: Measurement, isShown: boolean): HTMLElement {
    const { id, name, kind, place, volumeId, figures } = measurement;
    const isOfThisRun = this.list.isOfThisRun(measurement);
    const input = element("input", { value: name, maxLength: 24, ariaLabel: `Name of measurement ${id}` });
    input.onchange = () => {
      this.list.rename(id, input.value);
      input.blur();
      this.events.changed();
    };
    input.onkeydown = (event) => event.stopPropagation(); // letters are text here, not the page's keys
    const remove = element("button", { type: "button", textContent: "×", ariaLabel: `Remove measurement ${name}` });
    remove.onclick = () => {
      const at = [...this.items.children].indexOf(item);
      this.list.remove(id);
      remove.blur();
      this.events.changed();
      const next = this.items.children[at] ?? this.items.lastElementChild;
      next?.querySelector<HTMLElement>("button")?.focus();
    };
    const where = isShown
      ? place
      : `${place}, volume ${volumeId}${isOfThisRun ? "" : ", before the server was started again"}`;
    const text = element("span", {}, `${kindTitle(kind)} ${where}`);
    for (const figure of figures) {
      const what = figures.length > 1 ? ` ${figure.name}` : "";
      text.append(element("div", {}, element("b", {}, figureText(figure)), what));
    }
    const item = element("li", {}, input, text, remove);
    const plane = this.planeOf(measurement);
    if (plane) item.append(plane);
    item.classList.toggle("elsewhere", !isShown);
    return item;
  }

  /** A button for the plane through both points of a distance. */
  private planeOf({ kind, name, points, across }: Measurement): HTMLButtonElement | undefined {
    const view = kind === "distance" && across ? planeThrough(points[0]!, points[1]!, across) : undefined;
    if (!view || !this.mayMovePlanes) return undefined;
    const button = element("button", {
      type: "button",
      className: "wide",
      textContent: "Plane through both points",
      title: "Show the plane through both points, at right angles to the picture in which they were set",
      ariaDescription: `of measurement ${name}`,
    });
    button.onclick = () => this.events.wantPlane(view);
    return button;
  }

  /** The first click asks, since nothing brings them back. */
  private wantToForget(): void {
    const isSure = this.forget.textContent === kReally;
    this.forget.textContent = isSure ? kForget : kReally;
    if (isSure) {
      this.list.clear();
      this.events.changed();
    } else {
      window.setTimeout(() => (this.forget.textContent = kForget), kAskedMs);
    }
  }

  private save(): void {
    const file = new Blob([csvOf(this.list.all())], { type: "text/csv;charset=utf-8" });
    saveFile(file, `fanlight-measurements-${timeInName()}.csv`);
  }
}
