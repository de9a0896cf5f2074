// SPDX-License-Identifier: Apache-2.0
// What is measured, beside the picture; and the list of what was measured, in the panel.
import type { Picture } from "../../generated/fanlight_pb.js";
import { element, find } from "../element";
import { planeThrough, type PlaneView } from "../plane_through";
import { saveFile, timeInName } from "../save_file";
import { figureText, kKinds, type Kind } from "./figures";
import { csvOf, kindTitle, type Measurement, type MeasurementList } from "./measurement_list";

const kForget = "Remove all";
const kReally = "Really remove all?";
const kForgetsFile = "Remove all measurements, for all displays and from the recording's file";
const kForgetsList = "Remove all measurements, for all displays; files of recordings that have ended keep theirs";
const kAskedMs = 4000;

export interface MeasurePanelEvents {
  kindChosen(): void;
  /** The outline that is drawn is to be closed. */
  close(): void;
  takeBack(): void;
  wantVolume(): void;
  /** The plane through both points of a distance. */
  wantPlane(view: PlaneView): void;
  /** The sweep of a frame of the recording that is played. */
  wantFrame(number: bigint): void;
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
  private readonly where = find("#measurements-kept", HTMLElement);
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

  showList(picture: Picture | undefined): void {
    const all = this.list.all();
    this.section.hidden = all.length === 0 && !this.list.trouble;
    this.volume.hidden = this.list.outlinesOf(picture).length < 3;
    const shown = this.list.of(picture);
    const where = this.whereKept();
    if (this.where.textContent !== where) this.where.textContent = where; // else it would be read out again
    this.forget.disabled = !all.some((each) => this.list.mayChange(each));
    this.forget.title = this.list.withRecording ? kForgetsFile : kForgetsList;
    // An item stays while nothing that it shows changes: it may be about to be clicked.
    const key = [
      this.mayMovePlanes,
      this.list.withRecording,
      ...all.map((each) => {
        const is = [shown.includes(each), this.list.mayChange(each), this.list.isOfThisRun(each)];
        return `${each.id} ${each.name} ${is.join(" ")}`;
      }),
    ].join();
    const isTyping = document.activeElement instanceof HTMLInputElement && this.items.contains(document.activeElement);
    if (key === this.shownKey || isTyping) return;
    this.shownKey = key;
    const focused = [...this.items.querySelectorAll("button")].indexOf(document.activeElement as HTMLButtonElement);
    this.items.replaceChildren(...all.map((each) => this.item(each, shown.includes(each))));
    this.items.querySelectorAll("button")[focused]?.focus();
  }

  private item(measurement: Measurement, isShown: boolean): HTMLElement {
    const { id, name, kind, place, figures } = measurement;
    const mayChange = this.list.mayChange(measurement);
    const input = element("input", { value: name, maxLength: 24, ariaLabel: `Name of measurement ${name}` });
    input.readOnly = !mayChange;
    input.onchange = () => {
      this.list.rename(id, input.value);
      if (!input.value.trim()) input.value = name;
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
    remove.disabled = !mayChange;
    remove.title = input.title = mayChange ? "" : "An operator's display changes what the server keeps";
    const where = isShown ? place : [place, this.volumeText(measurement)].filter(Boolean).join(", ");
    const text = element("span", {}, `${kindTitle(kind)} ${where}`);
    for (const figure of figures) {
      const what = figures.length > 1 ? ` ${figure.name}` : "";
      text.append(element("div", {}, element("b", {}, figureText(figure)), what));
    }
    const item = element("li", {}, input, text, remove);
    if (!isShown && this.mayMovePlanes && this.list.withRecording && measurement.isKept)
      item.append(this.goTo(measurement));
    const plane = this.planeOf(measurement);
    if (plane) item.append(plane);
    item.classList.toggle("elsewhere", !isShown);
    return item;
  }

  private volumeText({ volumeId, runId, isKept, first, last }: Measurement): string {
    if (this.list.isOfThisRun({ runId })) return `volume ${volumeId}`;
    return isKept ? `frames ${first} to ${last}` : "before the server was started again";
  }

  /** Where the measurements are kept. */
  private whereKept(): string {
    const { trouble, withRecording } = this.list;
    const all = this.list.all();
    const onPage = all.filter(({ isKept }) => !isKept).length;
    const place = withRecording
      ? "with this recording"
      : "on the server until it stops, and with each recording that holds their volume";
    const kept = onPage < all.length ? `Kept ${place}.` : "";
    const own = onPage > 0 ? `${onPage} of ${all.length} on this page only.` : "";
    return [trouble || kept, own].filter(Boolean).join(" ");
  }

  /** Shows the volume of a measurement. */
  private goTo({ name, first, last }: Measurement): HTMLButtonElement {
    const what = "Show the sweep of the recording on which it was measured";
    return wideButton("Go to its volume", what, name, () => this.events.wantFrame((first + last) / 2n));
  }

  /** Shows the plane through both points of a distance. */
  private planeOf({ kind, name, points, across }: Measurement): HTMLButtonElement | undefined {
    const view = kind === "distance" && across ? planeThrough(points[0]!, points[1]!, across) : undefined;
    if (!view || !this.mayMovePlanes) return undefined;
    const what = "Show the plane through both points, at right angles to the picture in which they were set";
    return wideButton("Plane through both points", what, name, () => this.events.wantPlane(view));
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

function wideButton(textContent: string, title: string, name: string, onclick: () => void): HTMLButtonElement {
  const ariaDescription = `of measurement ${name}`;
  const button = element("button", { type: "button", className: "wide", textContent, title, ariaDescription });
  button.onclick = onclick;
  return button;
}
