// SPDX-License-Identifier: Apache-2.0
// The settings of a probe in the form of scene fields: fields and values by name.
import { create, type MessageInitShape } from "@bufbuild/protobuf";
import {
  ProbeSettingsSchema,
  ProbeStatus_State,
  SceneFieldSchema,
  type ProbeSettings,
  type ProbeStatus,
  type SceneField,
} from "../generated/fanlight_pb.js";
import { numberText } from "./field_text";
import { numberOf, type Values } from "./scene";

export const kProbeTitles: Readonly<Record<string, string>> = {
  "probe.sweep_deg": "Sweep angle",
  "probe.frames_a_volume": "Frames per volume",
  "probe.depth_mm": "Depth",
};

/** One field per setting, with the ranges of this probe. */
export function probeFields({ sweepDeg, framesAVolume, depthMm }: ProbeStatus): SceneField[] {
  const field = (init: MessageInitShape<typeof SceneFieldSchema>, range: { minimum: number; maximum: number }) =>
    create(SceneFieldSchema, { ...init, minimum: range.minimum, maximum: range.maximum });
  const none = { minimum: NaN, maximum: NaN };
  return [
    field({ name: "probe.sweep_deg", unit: "deg", help: "from first frame to last" }, sweepDeg ?? none),
    field({ name: "probe.frames_a_volume", step: 1, help: "more are finer and take longer" }, framesAVolume ?? none),
    field({ name: "probe.depth_mm", unit: "mm", help: "below the probe's face" }, depthMm ?? none),
  ];
}

export function probeValues(settings: ProbeSettings | undefined): Values {
  return new Map([
    ["probe.sweep_deg", settings?.sweepDeg ?? NaN],
    ["probe.frames_a_volume", settings?.framesAVolume ?? NaN],
    ["probe.depth_mm", settings?.depthMm ?? NaN],
  ]);
}

/** The body of a message that asks the probe for these values. */
export function probeChange(requestId: bigint, values: Values) {
  return { case: "probeChange", value: { requestId, settings: probeSettings(values) } } as const;
}

/** The message with these settings only. */
export function probeSettings(values: Values): ProbeSettings {
  const given = (name: string, key: keyof MessageInitShape<typeof ProbeSettingsSchema>) =>
    values.has(name) ? { [key]: numberOf(values.get(name)) } : {};
  return create(ProbeSettingsSchema, {
    ...given("probe.sweep_deg", "sweepDeg"),
    ...given("probe.frames_a_volume", "framesAVolume"),
    ...given("probe.depth_mm", "depthMm"),
  });
}

/** Why this page may not set the probe; undefined if it may. */
export function whyReadOnly({ state, mayBeSet }: ProbeStatus): string | undefined {
  if (!mayBeSet) return "Read-only: displays may not change the probe on this server.";
  if (state === ProbeStatus_State.LOST) return "Can be set again when the probe is back.";
  return undefined;
}

/** "70 deg, 35 frames, 160 mm" */
export function settingsText(value: (name: string) => number): string {
  const text = (name: string) => numberText(value(name));
  return `${text("probe.sweep_deg")} deg, ${text("probe.frames_a_volume")} frames, ${text("probe.depth_mm")} mm`;
}
