// SPDX-License-Identifier: Apache-2.0
// The picture, with its measurements and notes; and, if wanted, its scale, source and state below it.

import { kNotForDiagnosis } from "./measuring/measurement_list";
import type { PictureNote } from "./picture_notes";

export interface StillFacts {
  source: string;
  /** "Live", "Frozen, 12 s old", ... */
  state: string;
  volumeId: bigint;
  /** undefined where it is not known. */
  captured: Date | undefined;
  /** What is said in the foot: depths, cuts, volumes that were averaged. */
  said: string;
  /** One line each. */
  measurements: readonly string[];
  bar: { mm: number; pixels: number } | undefined;
  fullWidth: number;
  notes: readonly PictureNote[];
  /** Holds the depth scales of the panes. */
  scales: SVGSVGElement;
  /** Of the panes; none where there is one. */
  names: readonly string[];
  /** Whether scale, source, state and time stand below the picture. */
  withFoot: boolean;
}

// Of a picture of that height; in others all is larger in proportion.
const kHeight = 512;
const kFootHeight = 44;
const kBehindAlpha = 0.4; // as on the page
const kBarTextWidth = 84; // of "200 mm", with margins

export async function stillOf(
  canvas: HTMLCanvasElement,
  overlay: SVGSVGElement,
  facts: StillFacts,
): Promise<HTMLCanvasElement> {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [
    canvas.width,
    canvas.height + (facts.withFoot ? Math.round(kFootHeight * unitOf(canvas)) : 0),
  ];
  const context = copy.getContext("2d")!;
  context.drawImage(canvas, 0, 0);
  if (overlay.childElementCount > 0) context.drawImage(await imageOf(overlay, canvas), 0, 0);
  if (facts.withFoot) drawPanes(context, canvas, facts);
  drawNotes(context, canvas, facts.notes);
  const { measurements, withFoot } = facts;
  const needsSentence = measurements.length > 0 && !withFoot;
  drawMeasurements(context, canvas, needsSentence ? [...measurements, kNotForDiagnosis] : measurements);
  if (facts.withFoot) drawFoot(context, canvas, facts);
  return copy;
}

export async function pngOf(still: Promise<HTMLCanvasElement>): Promise<Blob> {
  const canvas = await still;
  const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, "image/png"));
  if (!blob) throw new Error("The browser cannot write this picture.");
  return blob;
}

/** Pixels of what is one pixel in a picture of the usual size. */
function unitOf(canvas: HTMLCanvasElement): number {
  return canvas.height / kHeight;
}

function drawNotes(context: CanvasRenderingContext2D, canvas: HTMLCanvasElement, notes: readonly PictureNote[]): void {
  const unit = unitOf(canvas);
  context.font = `600 ${14 * unit}px sans-serif`;
  context.lineWidth = 3 * unit;
  context.strokeStyle = "#000";
  context.fillStyle = "#fff";
  for (const note of notes) {
    context.globalAlpha = note.behind ? kBehindAlpha : 1;
    context.textAlign = note.endsHere ? "right" : "left";
    const place = [note.x * canvas.width, note.y * canvas.height, canvas.width / 2] as const;
    context.strokeText(note.text, ...place);
    context.fillText(note.text, ...place);
  }
  context.textAlign = "left";
  context.globalAlpha = 1;
}

const kMostLines = 12; // of measurements: more would cover the picture

/** Above the lower left corner, from the bottom up. */
function drawMeasurements(
  context: CanvasRenderingContext2D,
  canvas: HTMLCanvasElement,
  lines: readonly string[],
): void {
  if (lines.length === 0) return;
  const unit = unitOf(canvas);
  context.font = `600 ${13 * unit}px sans-serif`;
  context.lineWidth = 3 * unit;
  [context.strokeStyle, context.fillStyle] = ["#000", "#ffe14d"];
  const others = lines.length - kMostLines;
  const written = others > 0 ? [...lines.slice(0, kMostLines), `and ${others} more`] : lines;
  for (const [index, line] of [...written].reverse().entries()) {
    const place = [8 * unit, canvas.height - (10 + 17 * index) * unit, canvas.width - 16 * unit] as const;
    context.strokeText(line, ...place);
    context.fillText(line, ...place);
  }
}

/** The depth scales of the panes, and the panes' names. */
function drawPanes(context: CanvasRenderingContext2D, canvas: HTMLCanvasElement, { scales, names }: StillFacts): void {
  const unit = unitOf(canvas);
  context.font = `600 ${12 * unit}px sans-serif`;
  context.lineWidth = 3 * unit;
  [context.strokeStyle, context.fillStyle] = ["#000", "#fff"];
  const write = (text: string, x: number, y: number, align: CanvasTextAlign) => {
    context.textAlign = align;
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  };
  for (const text of scales.querySelectorAll("text.depth"))
    write(text.textContent ?? "", Number(text.getAttribute("x")), Number(text.getAttribute("y")), "right");
  const across = Math.ceil(Math.sqrt(names.length));
  for (const [index, name] of names.entries())
    write(
      name,
      (index % across) * (canvas.width / across) + 8 * unit,
      Math.floor(index / across) * (canvas.height / across) + 16 * unit,
      "left",
    );
  context.strokeStyle = "#fff";
  context.lineWidth = unit;
  for (const tick of scales.querySelectorAll("path.depth")) context.stroke(new Path2D(tick.getAttribute("d") ?? ""));
  context.textAlign = "left";
}

function drawFoot(context: CanvasRenderingContext2D, canvas: HTMLCanvasElement, facts: StillFacts): void {
  const unit = unitOf(canvas);
  context.save();
  context.translate(0, canvas.height);
  context.scale(unit, unit);
  const width = canvas.width / unit;
  context.fillStyle = "#0c1014";
  context.fillRect(0, 0, width, kFootHeight + 1); // its height was rounded
  context.fillStyle = "#fff";
  context.font = "13px sans-serif";
  const line = [facts.source, facts.state, `volume ${facts.volumeId}`, timeText(facts)].filter(Boolean).join("   ");
  context.fillText(line, 8, 16, width - 16);
  const barLength = facts.bar ? (facts.bar.pixels * width) / facts.fullWidth : 0;
  const said = [facts.said, kNotForDiagnosis].filter(Boolean).join(" ");
  context.fillText(said, 8, 36, width - barLength - kBarTextWidth);
  if (facts.bar) drawBar(context, facts.bar.mm, barLength, width - 8);
  context.restore();
}

function timeText({ captured }: StillFacts): string {
  const time = (captured ?? new Date()).toISOString().slice(0, 19).replace("T", " ");
  return `${captured ? "captured" : "saved"} ${time} UTC`;
}

function drawBar(context: CanvasRenderingContext2D, mm: number, length: number, right: number): void {
  const y = 34;
  context.fillRect(right - length, y, length, 2);
  context.fillRect(right - length, y - 4, 1, 6);
  context.fillRect(right - 1, y - 4, 1, 6);
  context.textAlign = "right";
  context.fillText(`${mm} mm`, right - length - 6, 36);
}

async function imageOf(overlay: SVGSVGElement, canvas: HTMLCanvasElement): Promise<HTMLCanvasElement> {
  const drawn = document.createElement("canvas");
  [drawn.width, drawn.height] = [canvas.width, canvas.height];
  const context = drawn.getContext("2d")!;
  const { width, height } = overlay.viewBox.baseVal;
  context.scale(canvas.width / width, canvas.height / height);
  [context.strokeStyle, context.fillStyle, context.lineWidth] = ["#ffe14d", "#ffe14d", 2];
  context.font = "600 14px sans-serif";
  for (const part of overlay.children) {
    if (part.classList.contains("offered")) continue; // not accepted yet
    context.globalAlpha = part.classList.contains("behind") ? kBehindAlpha : 1;
    if (part instanceof SVGPathElement) {
      context.setLineDash(part.classList.contains("path") ? [3, 3] : []);
      context.stroke(new Path2D(part.getAttribute("d") ?? ""));
    } else if (part instanceof SVGTextElement) {
      context.fillText(part.textContent ?? "", Number(part.getAttribute("x")), Number(part.getAttribute("y")));
    }
  }
  return drawn;
}
