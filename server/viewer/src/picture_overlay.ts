// SPDX-License-Identifier: Apache-2.0
// Everything that the page draws over the picture but the light, and the still that is saved with it.
import {
  CineRequest_Wish as CineWish,
  ReplayRequest_Wish as ReplayWish,
  Role,
  type Hello,
  type Picture,
  type ServerMessage,
  type View,
} from "../generated/fanlight_pb.js";
import type { Loss } from "./archive_button";
import { ClipButton } from "./clip_button";
import type { CodecChoice } from "./codec_choice";
import type { ClientBody } from "./connection";
import { DepthLegend } from "./depth_legend";
import { find } from "./element";
import type { Mm } from "./measuring/figures";
import { MeasureTool } from "./measuring/measure_tool";
import { page } from "./page";
import type { Strokes } from "./picture_input";
import { PictureNotes } from "./picture_notes";
import { PlaneOverlay } from "./plane_overlay";
import { directions, PictureMarks, scaleBar, type Direction, type ScaleBar } from "./picture_marks";
import { saveFile, timeInName } from "./save_file";
import type { SettingsEditor } from "./settings_editor";
import type { PlaneView } from "./plane_through";
import { Scalpel } from "./scalpel";
import { shownPlanes, sliceCamera } from "./shown_planes";
import { steadyText } from "./steady_mark";
import { pngOf, stillOf } from "./still";
import { SurfacePoints } from "./surface_points";
import { kTomography, planeDirections } from "./tomography";
import type { Tool } from "./tools";
import { surfacePart, tidy, type PagePoint, type Size } from "./view_geometry";

const kSurfaceModes = ["surface", "surface-and-volume", "depth", "slices"];

/** Of the panes that are shown, along the rows; none where there is one. */
function paneNames(): string[] {
  return [...document.querySelectorAll(":is(#pane-names, #tomography-names):not([hidden]) > span")].map(
    (name) => name.textContent ?? "",
  );
}

const kPreview = "This is a preview that the display has turned: wait for the picture of the server.";

export class PictureOverlay {
  readonly measurement: MeasureTool;
  readonly scalpel: Scalpel;
  readonly strokes: Strokes = {
    begin: (pointer) => this.scalpel.begin(pointer),
    move: (pointer) => this.scalpel.move(pointer),
    end: () => this.scalpel.end(),
    cancel: () => {
      this.scalpel.cancel();
      if (this.tool === "measure") this.measurement.cancel();
    },
  };
  private readonly points: SurfacePoints;
  readonly clip: ClipButton;
  private readonly notes: PictureNotes;
  private readonly planes: PlaneOverlay;
  private readonly depths: DepthLegend;
  private tool: Tool = "light";
  private allowed = false;
  private readonly lines = find("#measurement", SVGSVGElement);
  private readonly marks = new PictureMarks(
    {
      scale: find("#scale", HTMLElement),
      axes: find("#axes", SVGSVGElement),
    },
    page.frame,
  );

  constructor(
    private readonly editor: SettingsEditor,
    codec: CodecChoice,
    private readonly from: {
      hello(): Hello | undefined;
      shown(): Picture | undefined;
      isFrozen(): boolean;
      /** Whether this display has turned the picture: it shows nothing to measure or to save. */
      isPreview(): boolean;
      /** Whether the picture shows the values of the editor. */
      isCurrent(): boolean;
      mayFreeze(): boolean;
      freeze(): void;
      /** The point of the body at a pixel of the picture, if this display knows it. */
      surfaceAt(pixel: PagePoint): Mm | undefined;
      /** The view of what this display has drawn; undefined where the server has. */
      drawnView(): View | undefined;
      /** When a time of the server's clock was; undefined in a replay, and while the clock is not known. */
      dateOf(serverMs: number): Date | undefined;
      send(body: ClientBody): void;
      failed(sentence: string): void;
    },
  ) {
    const say = (sentence: string) => {
      page.measured.textContent = sentence;
      page.measured.hidden = sentence === "";
    };
    const ask = (requestId: bigint, pixels: PagePoint[]) =>
      from.send({
        case: "depth",
        value: { requestId, pixels: pixels.map(({ x, y }) => ({ column: x, row: y })), ...this.fullSize() },
      });
    this.points = new SurfacePoints(ask);
    this.scalpel = new Scalpel(editor, {
      view: () => from.drawnView() ?? from.shown()?.view,
      fullSize: () => this.fullSize(),
      surfaceAt: (pixels) =>
        from.drawnView() ? Promise.resolve(pixels.map((pixel) => from.surfaceAt(pixel))) : this.points.at(pixels),
      isPreview: () => from.isPreview(),
      say,
      failed: from.failed,
    });
    this.measurement = new MeasureTool(page.canvas, this.lines, {
      isFrozen: () => from.isFrozen(),
      mayFreeze: () => from.mayFreeze(),
      freeze: () => from.freeze(),
      showsSurface: () => kSurfaceModes.includes(this.editor.choice("mode")),
      planes: (size) => shownPlanes(this.editor.choice("mode"), size, sliceCamera(editor)),
      isCurrent: () => from.isCurrent(),
      showPlane: (view) => this.showPlane(view),
      showFrame: (number) => this.showFrame(number),
      captured: ({ captureTimeNs }) => from.dateOf(Number(captureTimeNs) / 1e6),
      fullSize: () => this.fullSize(),
      mode: () => this.editor.choice("mode"),
      targetDepthMm: () => this.editor.number("camera.distance_mm"),
      view: () => from.drawnView() ?? from.shown()?.view,
      surfaceAt: (pixel) => from.surfaceAt(pixel),
      ask,
      askFluid: (value) => from.send({ case: "fluid", value }),
      keep: (value) => from.send({ case: "measurement", value }),
      say,
    });
    this.notes = new PictureNotes(
      find("#picture-notes", HTMLElement),
      page.frame,
      ({ x, y }) => from.surfaceAt({ x: x * this.fullSize().width, y: y * this.fullSize().height }),
      from.failed,
    );
    this.depths = new DepthLegend(find("#depth-legend", HTMLElement), editor);
    this.planes = new PlaneOverlay(find("#planes", SVGSVGElement), page.canvas, editor, () => from.isCurrent());
    this.clip = new ClipButton(page.clip, {
      canFilm: () => codec.canFilm,
      wantFilm: (wanted) => codec.wantFilm(wanted),
      failed: from.failed,
    });
    page.still.onclick = () => this.still();
    page.openBox.onclick = () => this.planes.openBox();
    new ResizeObserver(() => this.showMarks()).observe(page.frame);
  }

  show(picture: Picture): void {
    this.measurement.show(picture);
    this.showMarks();
    this.drawn();
  }

  /** What is drawn now has another view: that of the picture, or of a preview. */
  drawn(): void {
    const view = this.from.drawnView() ?? this.from.shown()?.view;
    this.notes.place(this.showsBody ? view : undefined, this.fullSize());
    this.measurement.draw();
    this.scalpel.viewMayHaveChanged();
  }

  /** Call at the start of a session. */
  start(): void {
    const hello = this.from.hello();
    this.measurement.start(hello?.runId ?? 0n, hello !== undefined && hello.role !== Role.VIEWER);
    this.points.forget();
    this.scalpel.cancel();
  }

  /** Takes an answer to a question, or the measurements that the server keeps. */
  take(told: Extract<ServerMessage["body"], { case: "depthReply" | "fluidReply" | "measurements" }>): void {
    if (told.case === "fluidReply") return this.measurement.answeredFluid(told.value);
    if (told.case === "measurements") return this.measurement.takeKept(told.value);
    this.measurement.answered(told.value);
    this.points.answered(told.value);
  }

  choose(tool: Tool): void {
    this.tool = tool;
    this.measurement.choose(tool === "measure");
    this.notes.choose(tool === "note");
    this.planes.chooseCrop(tool === "crop");
    this.scalpel.choose(tool === "cut");
    page.openBox.hidden = tool !== "crop";
  }

  /** A click on the picture; whether the tool in hand takes it. */
  clicked(pointer: PagePoint): boolean {
    if (this.tool === "measure") {
      if (this.from.isPreview()) this.from.failed(kPreview);
      else this.measurement.clicked(pointer);
    }
    if (this.tool === "note") {
      if (this.from.isPreview()) this.from.failed(kPreview);
      else this.notes.clicked(pointer);
    }
    if (this.tool === "cut") this.scalpel.clicked(pointer);
    return ["measure", "note", "cut"].includes(this.tool);
  }

  /** Whether this display may move the planes and the crop box. In a view of its own the box is the shared one. */
  allow(may: boolean, ownView: boolean): void {
    this.allowed = may && !ownView;
    this.planes.allow(this.allowed);
    page.openBox.disabled = !this.allowed;
    this.scalpel.allow(this.allowed);
    this.measurement.allow(this.allowed);
  }

  /** The scene has changed. */
  refresh(): void {
    this.planes.draw();
    this.depths.refresh();
    this.measurement.refresh();
    this.scalpel.refresh();
    this.scalpel.viewMayHaveChanged();
  }

  private showFrame(number: bigint): void {
    if (this.from.isFrozen()) this.from.send({ case: "cine", value: { wish: CineWish.LIVE } });
    this.from.send({ case: "replay", value: { wish: ReplayWish.FRAME, value: Number(number) } });
  }

  /** Saves the picture, with its scale if that is wanted. */
  still(): void {
    this.stillBlob(page.stillFacts.checked)?.then(
      (png) => saveFile(png, `fanlight-${timeInName()}.png`),
      (error: Error) => this.from.failed(error.message),
    );
  }

  /** The picture as PNG; undefined where there is none, which it says. `withFoot`: with scale, source and time. */
  stillBlob(withFoot = true): Promise<Blob> | undefined {
    const missing = this.missing();
    return missing ? void this.from.failed(missing) : pngOf(this.drawStill(withFoot));
  }

  /** The same to be drawn elsewhere; undefined, without a word, where there is none. */
  stillCanvas(): Promise<HTMLCanvasElement> | undefined {
    return this.missing() ? undefined : this.drawStill(true);
  }

  private missing(): string {
    if (page.frame.hidden) return "There is no picture yet.";
    return this.from.isPreview() ? kPreview : "";
  }

  private drawStill(withFoot: boolean): Promise<HTMLCanvasElement> {
    const shown = this.from.shown();
    const facts = {
      source: this.from.hello()?.title ?? "",
      state: find("#connection", HTMLElement).innerText.trim(),
      volumeId: shown?.volumeId ?? 0n,
      captured: shown && this.from.dateOf(Number(shown.captureTimeNs) / 1e6),
      said: [this.depths.text(), this.scalpel.text(), shown && steadyText(shown)].filter(Boolean).join(" "),
      measurements: this.measurement.lines(),
      bar: this.bar(),
      fullWidth: this.fullSize().width,
      notes: this.notes.all(),
      scales: find("#planes", SVGSVGElement),
      names: paneNames(),
      withFoot,
    };
    return stillOf(page.canvas, this.lines, facts);
  }

  /** Of the volume on show. */
  volumeId(): bigint | undefined {
    return this.from.shown()?.volumeId;
  }

  /** How the picture came, where it has lost something on the way. */
  loss(): Loss | undefined {
    const shown = this.from.shown();
    if (!shown) return undefined;
    const bytes = shown.jpeg.length || shown.h264.length;
    if (bytes === 0) return undefined;
    const ratio = Math.max(1, (3 * shown.width * shown.height) / bytes);
    return { method: shown.jpeg.length > 0 ? "jpeg" : "h264", ratio };
  }

  /** The size in which the pixels of the view are counted. */
  private fullSize(): Size {
    const shown = this.from.shown();
    if (shown?.surface) return shown;
    const hello = this.from.hello();
    return { width: hello?.pictureWidth ?? 0, height: hello?.pictureHeight ?? 0 };
  }

  private bar(): ScaleBar | undefined {
    return scaleBar(this.from.shown()?.view, this.fullSize().width, this.editor.number("camera.distance_mm"));
  }

  private directions(view: View | undefined): readonly Direction[] {
    const isTomography = this.editor.choice("mode") === kTomography;
    const camera = sliceCamera(this.editor);
    const ofPlane = isTomography ? planeDirections(camera.plane, { view: camera, planes: camera.planes }) : undefined;
    return ofPlane ?? (view?.matrix.length === 16 ? directions(view) : []);
  }

  /** Whether the picture has a part that points of the body are drawn on. */
  private get showsBody(): boolean {
    return surfacePart(this.editor.choice("mode"), page.canvas) !== undefined;
  }

  private showPlane({ target: [x, y, z], yawDeg, pitchDeg, rollDeg }: PlaneView): void {
    this.editor.set([
      ["camera.yaw_deg", yawDeg],
      ["camera.pitch_deg", pitchDeg],
      ["camera.roll_deg", rollDeg],
      ["camera.target_x_mm", tidy(x)],
      ["camera.target_y_mm", tidy(y)],
      ["camera.target_z_mm", tidy(z)],
      ["slice.depth_mm", this.editor.number("camera.distance_mm")],
      ["mode", this.editor.choicesOf("mode").indexOf("slice")],
    ]);
  }

  private showMarks(): void {
    page.frame.dataset.mode = this.editor.choice("mode");
    const shown = this.from.shown();
    this.planes.show(shown?.view, this.fullSize().width, shown?.nearEndMm);
    this.marks.show(this.directions(shown?.view), this.bar(), this.fullSize().width);
  }
}
