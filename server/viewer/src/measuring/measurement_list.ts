// SPDX-License-Identifier: Apache-2.0
// The measurements of a session, and their file.
import type { RegionGrid } from "./region_border";
import { figuresOf, figureText, kKinds, volumeOf, type Figure, type Kind, type Mm } from "./figures";

export const kNotForDiagnosis = "Not for diagnosis.";
const kMost = 200;
const kBorderMoves = "The deviation is that of a border 1.5 dB higher or lower.";

export interface Measurement {
  id: number;
  /** The user's, or its number. */
  name: string;
  kind: Kind | "volume";
  /** "on the surface", "in plane A". */
  place: string;
  points: readonly Mm[];
  /** At right angles to the plane, or along the view at the surface. */
  across?: Mm;
  /** Of a distance on the surface: the points of the surface between its ends; absent where it leaves the surface. */
  path?: readonly Mm[];
  /** Of fluid: its border. */
  region?: RegionGrid;
  /** Standard deviation of each point along x, y and z. */
  sdMm: Mm;
  volumeId: bigint;
  /** Hello.run_id. */
  runId: bigint;
  captured?: Date;
  figures: readonly Figure[];
}

export type NewMeasurement = Omit<Measurement, "id" | "name" | "kind" | "runId" | "figures"> & { kind: Kind };

/**
 * Standard deviation of a point along x, y and z: the true place is anywhere between two samples, and in the pixel that
 * was clicked. `samplesMm`: Picture.sample_mm.
 */
export function placeSdMm(samplesMm: readonly number[], pixelMm: number): Mm {
  const along = (axis: number) => Math.sqrt(((samplesMm[axis] ?? 0) ** 2 + pixelMm ** 2) / 12);
  return [along(0), along(1), along(2)];
}

export class MeasurementList {
  private kept: Measurement[] = [];
  private lastId = 0;
  private runId = 0n;

  /** What follows is measured on volumes of this start of the server; what was measured before stays in the list. */
  startRun(runId: bigint): void {
    this.runId = runId;
  }

  all(): readonly Measurement[] {
    return this.kept;
  }

  /** Those of a volume of the present start. */
  of(volumeId: bigint | undefined): Measurement[] {
    return this.kept.filter((each) => each.volumeId === volumeId && each.runId === this.runId);
  }

  isOfThisRun({ runId }: Measurement): boolean {
    return runId === this.runId;
  }

  get isFull(): boolean {
    return this.kept.length >= kMost;
  }

  /** undefined where the points do not make one. */
  add(of: NewMeasurement): Measurement | undefined {
    return this.keep(of, figuresOf(of.kind, of.points, of.sdMm, of.path));
  }

  /** Fluid, with its volume; undefined where the list is full. */
  addFluid(of: Pick<Measurement, "place" | "points" | "region" | "volumeId" | "captured">, volume: Figure) {
    return this.isFull ? undefined : this.keep({ ...of, kind: "fluid", sdMm: [0, 0, 0] }, [volume]);
  }

  /** The volume inside outlinesOf(); undefined where they are fewer than three, or not parallel. */
  addVolume(volumeId: bigint): Measurement | undefined {
    const outlines = this.outlinesOf(volumeId);
    const volume = this.isFull ? undefined : volumeOf(outlines);
    if (!volume) return undefined;
    const place = `of the outlines ${outlines.map(({ name }) => name).join(", ")}`;
    const captured = outlines[0]?.captured;
    const of = { kind: "volume", place, points: [], sdMm: [0, 0, 0], volumeId } as const;
    return this.keep({ ...of, ...(captured && { captured }) }, [volume]);
  }

  /** The outlines in planes of an image volume since the last measured volume in it, so that several can be measured. */
  outlinesOf(volumeId: bigint | undefined): Measurement[] {
    const all = this.of(volumeId);
    const last = all.filter(({ kind }) => kind === "volume").at(-1);
    return all.filter(({ id, kind, place }) => kind === "area" && place.startsWith("in ") && id > (last?.id ?? 0));
  }

  rename(id: number, name: string): void {
    this.kept = this.kept.map((each) => (each.id === id ? { ...each, name: name.trim() || String(id) } : each));
  }

  remove(id: number): void {
    this.kept = this.kept.filter((each) => each.id !== id);
  }

  clear(): void {
    this.kept = [];
    this.lastId = 0;
  }

  private keep(of: Omit<Measurement, "id" | "name" | "runId" | "figures">, figures: Figure[]): Measurement | undefined {
    const isKnown = ({ value, uncertainty }: Figure) => Number.isFinite(value) && Number.isFinite(uncertainty);
    if (figures.length === 0 || !figures.every(isKnown)) return undefined;
    const id = (this.lastId += 1);
    const made = { ...of, id, name: String(id), runId: this.runId, figures };
    this.kept.push(made);
    return made;
  }
}

export function kindTitle(kind: Measurement["kind"]): string {
  return kind === "volume" ? "Volume" : kKinds[kind].title;
}

/** "12.3 ± 0.2 mm straight, 13.0 ± 0.2 mm along the surface"; a single one without its name. */
export function measurementText({ figures }: Pick<Measurement, "figures">): string {
  if (figures.length === 1) return figureText(figures[0]!);
  return figures.map((figure) => `${figureText(figure)} ${figure.name}`).join(", ");
}

/** "1 Distance: 12.3 ± 0.2 mm"; the first two figures, which fit into a picture. */
export function measurementLine({ name, kind, figures }: Measurement): string {
  return `${name} ${kindTitle(kind)}: ${measurementText({ figures: figures.slice(0, 2) })}`;
}

const kColumns =
  "name,kind,figure,value,unit,standard_deviation,place,volume_id,run_id,captured,points_mm_transducer_frame,note";

/** RFC 4180, one line for each figure. It begins with a byte order mark, by which spreadsheets know UTF-8. */
export function csvOf(measurements: readonly Measurement[]): string {
  const lines = measurements.flatMap((of) =>
    of.figures.map(({ name, value, unit, uncertainty }) =>
      [
        notFormula(of.name),
        kindTitle(of.kind).toLowerCase(),
        name,
        value.toFixed(3),
        unit.replace("²", "2").replace("³", "3"),
        uncertainty.toFixed(3),
        of.place.replaceAll("\u2212", "-"),
        String(of.volumeId),
        of.runId.toString(16),
        of.captured?.toISOString() ?? "",
        of.points.map((point) => point.map((mm) => mm.toFixed(2)).join(" ")).join("; "),
        of.kind === "fluid" ? `${kBorderMoves} ${kNotForDiagnosis}` : kNotForDiagnosis,
      ]
        .map(cell)
        .join(","),
    ),
  );
  return `\ufeff${[kColumns, ...lines, ""].join("\r\n")}`;
}

/** A spreadsheet takes what begins with one of these for a formula. */
function notFormula(text: string): string {
  return /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
}

function cell(text: string): string {
  return /[",\r\n;]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
