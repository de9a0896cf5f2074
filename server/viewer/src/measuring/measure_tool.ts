// SPDX-License-Identifier: Apache-2.0
// Measures on a frozen volume: points of the surface, or of one of the planes, make a distance, an angle, an ellipse or
// an area. Measurements stay in a list, and are drawn wherever their volume shows their place.
import type { DepthReply, FluidReply, MeasurementList as KeptList, Picture } from "../../generated/fanlight_pb.js";
import type { ShownPlane } from "../shown_planes";
import { planeAt, pointAt } from "../shown_planes";
import { picturePixel, type PagePoint } from "../view_geometry";
import { fitOf, showsSame } from "./answered_picture";
import { kKinds, type Kind, type Mm } from "./figures";
import { FluidProbe } from "./fluid_probe";
import type { MeasureEvents } from "./measure_events";
import { MeasurePanel } from "./measure_panel";
import { borderParts, clickedParts, drawnParts, fluidParts, type DrawnMeasurement } from "./measured_drawing";
import { acrossOf, forwardOf, mmOf, pixelAt, planePane, surfacePane } from "./measured_places";
import {
  kNotForDiagnosis,
  measurementLine,
  MeasurementList,
  measurementText,
  placeSdMm,
  volumeOfPicture,
  type Measurement,
} from "./measurement_list";
import { kDrawnHeight, pathPixels } from "./surface_path";

const kSurface = "on the surface";
const kClosePixels = 12; // of the page: a click so near to the first point closes an outline
const kSamePixels = 3; // of the page: the second click of a double click
const kChanged = "The picture has changed. Measure again.";
const kUnfit: Readonly<Record<Kind, string>> = {
  distance: "set two points that are apart.",
  angle: "set its vertex apart from both sides.",
  ellipse: "set the third point beside the axis, between its ends.",
  area: "its outline crosses itself, or is too small.",
  fluid: "", // the server says why
};

/** What is clicked so far. */
interface Pending {
  kind: Kind;
  place: string;
  /** Absent on the surface, whose points the server knows. */
  plane?: { points: Mm[]; across: Mm; pixelMm: number };
  /** In shares of the picture's width and height, so that another size of the picture changes nothing. */
  clicks: PagePoint[];
}

interface Asked {
  id: bigint;
  picture: Picture;
  pending: Pending;
  sdMm: Mm;
}

export class MeasureTool {
  private readonly list: MeasurementList;
  private readonly panel: MeasurePanel;
  private readonly fluid: FluidProbe;
  private pending: Pending | undefined;
  private asked: Asked | undefined; // of the server, which knows the surface
  private early: DepthReply | undefined; // the answer, of a picture that has not arrived yet
  private lastId = 0n;
  private picture: Picture | undefined;
  private chosen = false;
  private hinting = false; // what is said is a hint, which may change

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly overlay: SVGSVGElement,
    private readonly events: MeasureEvents,
  ) {
    this.list = new MeasurementList((wish) => events.keep(wish));
    this.panel = new MeasurePanel(this.list, {
      kindChosen: () => this.restart(),
      close: () => this.finish(),
      takeBack: () => this.takeBack(),
      wantVolume: () => this.measureVolume(),
      wantPlane: (view) => this.events.showPlane(view),
      wantFrame: (number) => this.events.showFrame(number),
      changed: () => this.draw(),
    });
    this.fluid = new FluidProbe(this.list, {
      ask: (question) => this.events.askFluid(question),
      say: (sentence) => this.say(sentence),
      captured: (picture) => this.events.captured(picture),
      changed: () => this.draw(),
      dropped: () => this.sayHint(),
    });
  }

  /** The tool was chosen, or left. */
  choose(chosen: boolean): void {
    this.chosen = chosen;
    this.panel.show(chosen);
    if (chosen) this.freeze();
    this.restart();
  }

  /** Gives up what is under way. */
  cancel(): void {
    this.restart();
  }

  /** Begins a session. `runId`: Hello.run_id. `mayKeep`: whether it may keep measurements on the server. */
  start(runId: bigint, mayKeep: boolean): void {
    this.pending = this.asked = this.picture = undefined;
    this.fluid.drop();
    this.list.startRun(runId, mayKeep);
    this.draw();
  }

  /** The measurements that the server keeps. */
  takeKept(kept: KeptList): void {
    this.list.take(kept);
    this.draw();
  }

  /** The picture was frozen, or is live again. */
  frozenChanged(): void {
    if (!this.chosen) return;
    if (!this.events.isFrozen()) this.pending = undefined;
    this.sayHintAgain();
    this.draw();
  }

  /** The scene, or what is drawn of it, has changed. */
  refresh(): void {
    this.sayHintAgain();
    this.draw();
  }

  clicked(pointer: PagePoint): void {
    if (!this.events.isFrozen() || !this.picture) {
      this.freeze();
      return this.sayHint();
    }
    if (this.asked || this.fluid.isAsking)
      return this.say("The last measurement is still under way: click again then.");
    if (this.list.isFull) return this.say("There are many measurements already: remove some first.");
    const pixel = picturePixel(pointer, this.canvas);
    const plane = planeAt(pixel, this.events.planes(this.canvas));
    if (!plane && this.panel.kind() === "fluid") {
      this.fluid.drop();
      return this.sayHint();
    }
    if (!plane && !this.events.showsSurface()) return this.sayHint();
    if (plane && !this.events.isCurrent())
      return this.say("These planes are not drawn yet, or this display is on hold: click again.");
    this.add(pixel, plane);
  }

  /** Adds a point, begins a measurement with it, or closes an outline. */
  private add(pixel: PagePoint, plane: ShownPlane | undefined): void {
    const place = plane ? `in ${plane.name}` : kSurface;
    const isElsewhere = this.pending !== undefined && this.pending.place !== place;
    if (isElsewhere) this.pending = undefined;
    const pending = (this.pending ??= this.begun(place, plane));
    const { clicks, kind } = pending;
    const shown = this.canvas.getBoundingClientRect();
    const share = { x: pixel.x / this.canvas.width, y: pixel.y / this.canvas.height };
    const apart = (from: PagePoint | undefined) =>
      from ? Math.hypot((from.x - share.x) * shown.width, (from.y - share.y) * shown.height) : Infinity;
    const mayClose = kind === "area" && clicks.length >= 3;
    if (mayClose && apart(clicks[0]) < kClosePixels) return this.finish();
    if (apart(clicks.at(-1)) < kSamePixels) return mayClose ? this.finish() : undefined;
    clicks.push(share);
    if (plane) pending.plane?.points.push(mmOf(pointAt(pixel, plane)));
    if (clicks.length === kKinds[kind].points) return this.finish();
    if (isElsewhere) this.say(`All points lie in one plane or on the surface: begun again. ${this.hint()}`);
    else this.sayHint();
    this.draw();
  }

  private begun(place: string, plane: ShownPlane | undefined): Pending {
    const begun = { kind: this.panel.kind(), place, clicks: [] };
    if (!plane) return begun;
    const pixelMm = plane.fieldMm / plane.part.height;
    return { ...begun, plane: { points: [], across: acrossOf(plane), pixelMm } };
  }

  answered(reply: DepthReply): void {
    const { requestId, pictureId, points, refused } = reply;
    const asked = this.asked;
    if (!asked || requestId !== asked.id) return;
    const fit = refused ? "changed" : fitOf(pictureId, asked.picture, this.picture ?? asked.picture);
    this.early = fit === "awaited" ? reply : undefined;
    if (this.early) return;
    this.asked = undefined;
    if (refused) return this.say(refused.message);
    if (fit === "changed") return this.say(kChanged);
    const found = points.map(({ surface, xMm, yMm, zMm }) => (surface ? ([xMm, yMm, zMm] as const) : undefined));
    const isDistance = asked.pending.kind === "distance";
    const corners = isDistance ? [found[0], found.at(-1)] : found;
    if (!corners.every((point) => point !== undefined))
      return this.say("A point is not on the surface. Click points of the surface.");
    const isWhole = isDistance && found.every((point) => point !== undefined);
    this.keep(asked, corners as Mm[], isWhole ? (found as Mm[]) : undefined);
  }

  answeredFluid(reply: FluidReply): void {
    this.fluid.answered(reply);
  }

  /** The picture on show; a measurement belongs to its volume. */
  show(picture: Picture): void {
    const isSame = this.picture !== undefined && showsSame(this.picture, picture);
    const isOther = this.picture?.volumeId !== picture.volumeId;
    const isCancelled = !isSame && this.pending !== undefined;
    this.picture = picture;
    if (!isSame) this.pending = undefined;
    if (isOther) this.fluid.drop();
    if (isCancelled) this.say(kChanged);
    else if (isOther && this.chosen) this.sayHint();
    else this.sayHintAgain();
    if (this.early) this.answered(this.early);
    this.draw();
  }

  /** Whether this display may move the planes. */
  allow(may: boolean): void {
    this.panel.allowPlanes(may);
    this.panel.showList(this.picture);
  }

  /** For a still: one line for each measurement that is drawn, and for each volume. */
  lines(): string[] {
    const drawn = this.drawn().map(({ measurement }) => measurement);
    const volumes = this.list
      .of(this.picture)
      .filter((each) => ["volume", "fluid"].includes(each.kind) && !drawn.includes(each));
    return [...drawn, ...volumes].map(measurementLine);
  }

  private say(sentence: string): void {
    this.hinting = false;
    this.events.say(sentence);
  }

  private sayHint(): void {
    this.say(this.chosen ? this.hint() : "");
    this.hinting = this.chosen;
  }

  private sayHintAgain(): void {
    if (this.hinting) this.sayHint();
  }

  private restart(): void {
    this.pending = this.asked = undefined;
    this.fluid.drop();
    this.sayHint();
    this.draw();
  }

  private takeBack(): void {
    this.pending?.clicks.pop();
    this.pending?.plane?.points.pop();
    if (this.pending?.clicks.length === 0) this.pending = undefined;
    this.sayHint();
    this.draw();
  }

  /** All points are there. */
  private finish(): void {
    const { pending, picture } = this;
    this.pending = undefined;
    if (!pending || !picture) return;
    if (pending.kind === "fluid") return this.fluid.begin(picture, pending.plane!.points[0]!, pending.place);
    const sdMm = placeSdMm(picture.sampleMm, pending.plane?.pixelMm ?? this.surfacePixelMm(picture));
    const asked = { id: (this.lastId += 1n), picture, pending, sdMm };
    if (pending.plane) return this.keep(asked, pending.plane.points);
    this.asked = asked;
    const full = this.events.fullSize();
    const pixels = pending.clicks.map((share) => pixelAt(share, full));
    const isDistance = pending.kind === "distance";
    this.events.ask(this.lastId, isDistance ? pathPixels(pixels[0]!, pixels[1]!, full.height) : pixels);
    this.draw();
  }

  private keep({ picture, pending, sdMm }: Asked, points: readonly Mm[], path?: readonly Mm[]): void {
    const captured = this.events.captured(picture);
    const across = pending.plane?.across ?? forwardOf(picture.view);
    const made = this.list.add({
      kind: pending.kind,
      place: pending.place,
      points,
      ...(path && { path }),
      ...(across && { across }),
      of: volumeOfPicture(picture),
      ...(captured && { captured }),
      sdMm,
    });
    if (!made) this.say(`These points make no ${kKinds[pending.kind].title.toLowerCase()}: ${kUnfit[pending.kind]}`);
    else this.sayResult(made, pending);
    this.draw();
  }

  private sayResult(made: Measurement, { plane }: Pending): void {
    const leaves = made.kind === "distance" && !plane && !made.path ? ", the path leaves the surface" : "";
    this.say(`${measurementText(made)}${leaves}. ${kNotForDiagnosis}`);
  }

  private measureVolume(): void {
    const made = this.picture && this.list.addVolume(this.picture);
    this.say(
      made
        ? `${measurementText(made)}, ${made.place}. ${kNotForDiagnosis}`
        : "A volume needs three or more outlines in planes that are parallel and apart from each other.",
    );
    this.draw();
  }

  /** Size in the body, at the target, of a pixel that is clicked on the surface. */
  private surfacePixelMm({ view }: Picture): number {
    const fullMm = (view?.mmPerPixel ?? 0) + this.events.targetDepthMm() * (view?.mmPerPixelPerMm ?? 0);
    return (fullMm * this.events.fullSize().height) / (this.canvas.height || 1);
  }

  /** A moving surface cannot be measured. */
  private freeze(): void {
    if (this.canShow() && !this.events.isFrozen() && this.events.mayFreeze()) this.events.freeze();
  }

  private canShow(): boolean {
    return this.events.showsSurface() || this.events.planes(this.canvas).length > 0;
  }

  private hint(): string {
    if (!this.canShow()) return "This picture shows nothing to measure. Choose Face, or planes.";
    if (!this.events.isFrozen())
      return this.events.mayFreeze()
        ? "Click a point: the first click freezes the picture."
        : "Only a picture that is frozen for all displays can be measured: the display in control freezes it.";
    const { hints } = kKinds[this.panel.kind()];
    return hints[Math.min(this.pending?.clicks.length ?? 0, hints.length - 1)]!;
  }

  /** The measurements that the picture shows, in the units of what is drawn. */
  private drawn(): DrawnMeasurement[] {
    const [planes, { height }] = [this.currentPlanes(), this.canvas];
    const partsOf = (measurement: Measurement) => {
      if (measurement.kind === "fluid") return fluidParts(measurement, planes, height);
      const isOnSurface = measurement.place === kSurface;
      const pane = isOnSurface ? this.surfacePane() : planePane(measurement, planes, height);
      return pane && drawnParts(measurement, pane);
    };
    return this.list.of(this.picture).flatMap((measurement) => {
      const parts = partsOf(measurement);
      return parts ? [{ measurement, parts }] : [];
    });
  }

  private currentPlanes(): readonly ShownPlane[] {
    return this.events.isCurrent() ? this.events.planes(this.canvas) : [];
  }

  private surfacePane() {
    return surfacePane(this.events.mode(), this.events.fullSize(), this.events.view(), (pixel) =>
      this.events.surfaceAt(pixel),
    );
  }

  /** Lines and texts have one size whatever that of the picture. */
  private get drawnWidth(): number {
    const full = this.events.fullSize();
    return (kDrawnHeight * (full.width || 1)) / (full.height || 1);
  }

  /** What the picture shows has moved. */
  draw(): void {
    const width = this.drawnWidth;
    this.overlay.setAttribute("viewBox", `0 0 ${width} ${kDrawnHeight}`);
    const clicks = this.pending?.clicks.map(({ x, y }) => ({ x: x * width, y: y * kDrawnHeight })) ?? [];
    const underWay = clickedParts(clicks, this.pending?.kind === "area");
    const { shown } = this.fluid;
    const offered = shown ? borderParts(shown, this.currentPlanes(), this.canvas.height, "offered") : [];
    this.fluid.setSeen(offered.length > 0);
    this.overlay.replaceChildren(...this.drawn().flatMap(({ parts }) => parts), ...offered, ...underWay);
    this.panel.underWay(clicks.length);
    this.panel.showList(this.picture);
  }
}
