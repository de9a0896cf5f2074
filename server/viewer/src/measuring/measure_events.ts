// SPDX-License-Identifier: Apache-2.0
// What the measuring tool asks of the page.
import type { Picture, View } from "../../generated/fanlight_pb.js";
import type { PlaneView } from "../plane_through";
import type { ShownPlane } from "../shown_planes";
import type { PagePoint, Size } from "../view_geometry";
import type { Mm } from "./figures";
import type { FluidQuestion } from "./fluid_probe";
import type { MeasurementWish } from "./kept_measurements";

export interface MeasureEvents {
  isFrozen(): boolean;
  mayFreeze(): boolean;
  freeze(): void;
  showsSurface(): boolean;
  /** Of the scene, which the picture on show may not show yet. */
  planes(size: Size): ShownPlane[];
  /** Whether the picture shows the values of the scene. */
  isCurrent(): boolean;
  fullSize(): Size;
  showPlane(view: PlaneView): void;
  showFrame(number: bigint): void;
  mode(): string;
  /** From the view plane to the camera's target. */
  targetDepthMm(): number;
  /** Of what is drawn: of the picture, or a preview. */
  view(): View | undefined;
  /** The point of the body at a pixel, if this display knows it. */
  surfaceAt(pixel: PagePoint): Mm | undefined;
  /** When the picture was captured, where that is known. */
  captured(picture: Picture): Date | undefined;
  ask(requestId: bigint, pixels: PagePoint[]): void;
  askFluid(question: FluidQuestion): void;
  /** Of the server, which keeps measurements. */
  keep(wish: MeasurementWish): void;
  /** Empty: nothing to say. */
  say(sentence: string): void;
}
