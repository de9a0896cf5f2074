// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { ProbeSettingsSchema, ProbeStatusSchema, ProbeStatus_State } from "../generated/fanlight_pb.js";
import { rangeText } from "../src/field_text";
import { probeFields, probeSettings, probeValues, settingsText, whyReadOnly } from "../src/probe_settings";

const status = create(ProbeStatusSchema, {
  state: ProbeStatus_State.STREAMING,
  settings: { sweepDeg: 70, framesAVolume: 35, depthMm: 160 },
  sweepDeg: { minimum: 10, maximum: 85 },
  framesAVolume: { minimum: 8, maximum: 140 },
  depthMm: { minimum: 40, maximum: 240 },
  mayBeSet: true,
});

test("each setting has the range that the probe has", () => {
  assert.deepEqual(
    probeFields(status).map((field) => `${field.name}: ${rangeText(field)}`),
    ["probe.sweep_deg: 10 to 85 deg", "probe.frames_a_volume: 8 to 140", "probe.depth_mm: 40 to 240 mm"],
  );
});

test("a change holds what was changed and nothing else", () => {
  const sent = toBinary(ProbeSettingsSchema, probeSettings(new Map([["probe.depth_mm", 120.5]])));
  const { sweepDeg, framesAVolume, depthMm } = fromBinary(ProbeSettingsSchema, sent);
  assert.deepEqual([sweepDeg, framesAVolume, depthMm], [undefined, undefined, 120.5]);
  const all = probeValues(status.settings);
  assert.deepEqual(probeValues(probeSettings(all)), all);
});

test("the settings in force are one line", () => {
  const values = probeValues(status.settings);
  assert.equal(
    settingsText((name) => values.get(name) as number),
    "70 deg, 35 frames, 160 mm",
  );
});

test("a probe that may not be set, or is not there, says why", () => {
  assert.equal(whyReadOnly(status), undefined);
  assert.match(whyReadOnly({ ...status, state: ProbeStatus_State.LOST }) ?? "", /when the probe is back/);
  assert.match(
    whyReadOnly({ ...status, state: ProbeStatus_State.LOST, mayBeSet: false }) ?? "",
    /may not change the probe/,
  );
});
