// SPDX-License-Identifier: Apache-2.0
// The measurements of a session, and their file.
import type { MeasurementList as KeptList, Picture } from "../../generated/fanlight_pb.js";
import { keptMeasurement, wishToAdd, type MeasurementWish } from "./kept_measurements";
import type { RegionGrid } from "./region_border";
import { figuresOf, figureText, kKinds, volumeOf, type Figure, type Kind, type Mm } from "./figures";

export const kNotForDiagnosis = "Not for diagnosis.";
const kMost = 200;
const kBorderMoves = "The deviation is that of a border 1.5 dB higher or lower.";

export interface Measurement {
  /** Random. */
  id: bigint;
  /** The server keeps it; else this page alone has it. */
  isKept: boolean;
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
  /** Picture.first_frame_number and last_frame_number of its volume. */
  first: bigint;
  last: bigint;
  volumeId: bigint;
  /** Hello.run_id. */
  runId: bigint;
  captured?: Date;
  figures: readonly Figure[];
}

type Made = Omit<Measurement, "id" | "isKept" | "name" | "runId" | "figures" | keyof VolumeKey> & { of: VolumeKey };
export type NewMeasurement = Made & { kind: Kind };

/** The volume that a picture shows. */
type VolumeKey = Pick<Measurement, "first" | "last" | "volumeId">;

export function volumeOfPicture({ firstFrameNumber, lastFrameNumber, volumeId }: Picture): VolumeKey {
  return { first: firstFrameNumber, last: lastFrameNumber, volumeId };
}

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
  private readonly madeHere = new Set<bigint>();
  private readonly sent = new Set<bigint>(); // in this session: the server has them, or has refused them
  private lastNumber = 0;
  private runId = 0n;
  /** Where the server keeps them, and what went wrong there. */
  withRecording = false;
  trouble = "";
  /** Whether this session may keep measurements on the server. */
  mayKeep = false;

  /** `send`: to the server. */
  constructor(private readonly send: (wish: MeasurementWish) => void = () => {}) {}

  /** What follows is measured on volumes of this start of the server; what was measured before stays in the list. */
  startRun(runId: bigint, mayKeep: boolean): void {
    this.sent.clear();
    if (runId !== this.runId) this.kept = this.kept.map((each) => ({ ...each, isKept: false }));
    this.runId = runId;
    this.mayKeep = mayKeep;
  }

  /** What the server keeps has changed, or a session begins. */
  take({ ids, changed, withRecording, trouble }: KeptList): void {
    this.withRecording = withRecording;
    this.trouble = trouble;
    const known = new Map(this.kept.map((each) => [each.id, each]));
    for (const each of changed.map(keptMeasurement)) if (each) known.set(each.id, each);
    const listed = ids.flatMap((id) => {
      const each = known.get(id);
      return each ? [{ ...each, isKept: true }] : [];
    });
    const own = this.kept.filter(({ id, isKept }) => !isKept && !ids.includes(id));
    const isBefore = (each: Measurement) => each.runId !== this.runId;
    this.kept = [...own.filter(isBefore), ...listed, ...own.filter((each) => !isBefore(each))];
    const numbers = this.kept.map(({ name }) => (/^\d{1,4}$/.test(name) ? Number(name) : 0));
    this.lastNumber = Math.max(this.lastNumber, ...numbers);
    this.sendOwn();
  }

  /** Sends what was measured while there was no connection. The server's region of fluid is not there any more. */
  private sendOwn(): void {
    const isLost = (each: Measurement) => !each.isKept && this.isOfThisRun(each) && !this.sent.has(each.id);
    for (const each of this.kept.filter((of) => isLost(of) && of.kind !== "fluid")) this.sendMade(each);
  }

  mayChange({ isKept }: Measurement): boolean {
    return this.mayKeep || !isKept;
  }

  all(): readonly Measurement[] {
    return this.kept;
  }

  /** Those on the volume of a picture. */
  of(picture: Picture | undefined): Measurement[] {
    if (!picture) return [];
    return this.kept.filter((each) => isOfVolume(each, picture) && (each.isKept || this.isOfThisRun(each)));
  }

  isOfThisRun({ runId }: Pick<Measurement, "runId">): boolean {
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
  addFluid(of: Pick<Made, "place" | "points" | "region" | "of" | "captured">, volume: Figure) {
    return this.isFull ? undefined : this.keep({ ...of, kind: "fluid", sdMm: [0, 0, 0] }, [volume]);
  }

  /** The volume inside outlinesOf(); undefined where they are fewer than three, or not parallel. */
  addVolume(picture: Picture): Measurement | undefined {
    const outlines = this.outlinesOf(picture);
    const volume = this.isFull ? undefined : volumeOf(outlines);
    if (!volume) return undefined;
    const place = `of the outlines ${outlines.map(({ name }) => name).join(", ")}`;
    const captured = outlines[0]?.captured;
    const made = { kind: "volume", place, points: [], sdMm: [0, 0, 0], of: volumeOfPicture(picture) } as const;
    return this.keep({ ...made, ...(captured && { captured }) }, [volume]);
  }

  /**
   * The outlines in planes of an image volume since the last measured volume in it, so that several can be measured. Other
   * displays may outline another body: where this page has outlines of its own, only these.
   */
  outlinesOf(picture: Picture | undefined): Measurement[] {
    const all = this.of(picture);
    const outlines = (of: Measurement[]) => {
      const since = of.slice(of.map(({ kind }) => kind).lastIndexOf("volume") + 1);
      return since.filter(({ kind, place }) => kind === "area" && place.startsWith("in "));
    };
    const own = all.filter(({ id }) => this.madeHere.has(id));
    return outlines(own.length > 0 ? own : all);
  }

  /** An empty name changes nothing. */
  rename(id: bigint, wanted: string): void {
    const name = wanted.trim();
    if (!name) return;
    this.kept = this.kept.map((each) => (each.id === id ? { ...each, name } : each));
    if (this.hasServer(id)) this.send({ wish: { case: "rename", value: { id, name } } });
  }

  remove(id: bigint): void {
    const wasSent = this.hasServer(id);
    this.kept = this.kept.filter((each) => each.id !== id);
    if (wasSent) this.send({ wish: { case: "remove", value: id } });
  }

  /** All that this session may remove. */
  clear(): void {
    const wereSent = this.mayKeep && this.kept.some(({ id }) => this.hasServer(id));
    this.kept = this.kept.filter((each) => !this.mayChange(each));
    this.lastNumber = 0;
    if (wereSent) this.send({ wish: { case: "removeAll", value: true } });
  }

  /** Also where its answer is not here yet. */
  private hasServer(id: bigint): boolean {
    return this.sent.has(id) || this.kept.some((each) => each.id === id && each.isKept);
  }

  private keep({ of, ...what }: Made, figures: Figure[]): Measurement | undefined {
    const isKnown = ({ value, uncertainty }: Figure) => Number.isFinite(value) && Number.isFinite(uncertainty);
    if (figures.length === 0 || !figures.every(isKnown)) return undefined;
    const [id] = crypto.getRandomValues(new BigUint64Array(1)) as unknown as [bigint];
    const name = String((this.lastNumber += 1));
    const made = { ...what, ...of, id, isKept: false, name, runId: this.runId, figures };
    this.kept.push(made);
    this.madeHere.add(id);
    this.sendMade(made);
    return made;
  }

  private sendMade(made: Measurement): void {
    if (!this.mayKeep) return;
    this.sent.add(made.id);
    this.send(wishToAdd(made));
  }
}

/** Measurement.first_frame_number */
function isOfVolume({ first, last }: Measurement, { firstFrameNumber, lastFrameNumber }: Picture): boolean {
  const most = (last - first + 1n) / 10n;
  const isNear = (a: bigint, b: bigint) => a - b <= most && b - a <= most;
  return isNear(first, firstFrameNumber) && isNear(last, lastFrameNumber);
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
  "name,kind,figure,value,unit,standard_deviation,place,volume_id,run_id,captured,points_mm_transducer_frame,note," +
  "first_frame,last_frame";

/** RFC 4180, one line for each figure. It begins with a byte order mark, by which spreadsheets know UTF-8. */
export function csvOf(measurements: readonly Measurement[]): string {
  const lines = measurements.flatMap((of) =>
    of.figures.map(({ name, value, unit, uncertainty }) =>
      [
        notFormula(of.name),
        kindTitle(of.kind).toLowerCase(),
        notFormula(name),
        value.toFixed(3),
        notFormula(unit.replace("²", "2").replace("³", "3")),
        uncertainty.toFixed(3),
        notFormula(of.place.replaceAll("\u2212", "-")),
        String(of.volumeId),
        of.runId.toString(16),
        of.captured?.toISOString() ?? "",
        of.points.map((point) => point.map((mm) => mm.toFixed(2)).join(" ")).join("; "),
        of.kind === "fluid" ? `${kBorderMoves} ${kNotForDiagnosis}` : kNotForDiagnosis,
        String(of.first),
        String(of.last),
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
