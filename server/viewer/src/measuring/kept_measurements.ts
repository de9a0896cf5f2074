// SPDX-License-Identifier: Apache-2.0
// Measurements that the server keeps, as messages.
import type { MessageInitShape } from "@bufbuild/protobuf";
import type {
  Measurement as Message,
  Measurement_Point as Point,
  MeasurementRequestSchema,
} from "../../generated/fanlight_pb.js";
import type { Figure, Mm } from "./figures";
import type { Measurement } from "./measurement_list";
import { regionGrid } from "./region_border";

export type MeasurementWish = MessageInitShape<typeof MeasurementRequestSchema>;

const kKindNames = ["distance", "angle", "ellipse", "area", "fluid", "volume"] as const; // Measurement.Kind

const kMostOnPath = 100; // points

const mmOf = ({ xMm, yMm, zMm }: Point): Mm => [xMm, yMm, zMm];
const pointOf = ([xMm, yMm, zMm]: Mm) => ({ xMm, yMm, zMm });

/** For drawing: what was measured along it is known. */
function thinned(path: readonly Mm[]): readonly Mm[] {
  const step = Math.ceil(path.length / kMostOnPath);
  return path.filter((_, index) => index % step === 0 || index === path.length - 1);
}

export function wishToAdd(made: Measurement): MeasurementWish {
  const { id, name, kind, place, points, across, path, sdMm, figures, first, last, captured, volumeId, runId } = made;
  const value = {
    id,
    name,
    kind: kKindNames.indexOf(kind),
    place,
    points: points.map(pointOf),
    ...(across && { across: pointOf(across) }),
    path: thinned(path ?? []).map(pointOf),
    deviationMm: pointOf(sdMm),
    figures: figures.map(({ uncertainty, ...figure }) => ({ ...figure, deviation: uncertainty })),
    firstFrameNumber: first,
    lastFrameNumber: last,
    capturedUnixMs: BigInt(captured?.getTime() ?? 0),
    volumeId,
    runId,
  };
  return { wish: { case: "add", value }, withRegion: kind === "fluid" };
}

/** undefined where this page knows no measurement of its kind. */
export function keptMeasurement(message: Message): Measurement | undefined {
  const kind = kKindNames[message.kind];
  if (!kind) return undefined;
  const { id, name, place, volumeId, runId, across, path, region, deviationMm, capturedUnixMs } = message;
  const grid = region && regionGrid(region);
  return {
    id,
    name,
    kind,
    place,
    volumeId,
    runId,
    isKept: true,
    first: message.firstFrameNumber,
    last: message.lastFrameNumber,
    points: message.points.map(mmOf),
    sdMm: deviationMm ? mmOf(deviationMm) : [0, 0, 0],
    figures: message.figures.map(({ name, value, unit, deviation }) => {
      return { name, value, unit: unit as Figure["unit"], uncertainty: deviation };
    }),
    ...(across && { across: mmOf(across) }),
    ...(path.length > 0 && { path: path.map(mmOf) }),
    ...(grid && { region: grid }),
    ...(capturedUnixMs && { captured: new Date(Number(capturedUnixMs)) }),
  };
}
