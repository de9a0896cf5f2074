// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create, type MessageInitShape } from "@bufbuild/protobuf";
import {
  RecordingRequest_Wish as Wish,
  RecordingStatus_State as State,
  RecordingStatusSchema,
} from "../generated/fanlight_pb.js";
import { recordingText } from "../src/recording_bar";

function told(status: MessageInitShape<typeof RecordingStatusSchema>) {
  return recordingText(create(RecordingStatusSchema, { available: true, ...status }));
}

test("a server without a folder for recordings offers nothing", () => {
  assert.equal(told({ available: false }), undefined);
});

test("the state of a recording is shown, with the button that ends it", () => {
  assert.deepEqual(told({}), { text: "", kind: "quiet", wish: Wish.START, keeps: false });
  const under = { state: State.RECORDING, durationS: 83.9, bytes: 340_400_000n };
  assert.deepEqual(told(under), { text: "Recording 1:23, 340 MB", kind: "recording", wish: Wish.STOP, keeps: false });
  assert.equal(told({ ...under, bytes: 2_340_000_000n })?.text, "Recording 1:23, 2.3 GB");
  assert.equal(told({ ...under, framesMissed: 3n })?.kind, "trouble");
  assert.equal(told({ lastFile: "a.igs.mha" })?.text, "Saved a.igs.mha");
  assert.equal(told({ state: State.FINISHING, file: "a.igs.mha", finishShare: 0.4 })?.text, "Saving a.igs.mha, 40 %");
});

test("trouble is shown before what was saved", () => {
  const full = { state: State.NO_ROOM, trouble: "the disk is full", lastFile: "a.igs.mha" };
  assert.deepEqual(told(full), {
    text: "Not recording: the disk is full",
    kind: "trouble",
    wish: Wish.STOP,
    keeps: false,
  });
  assert.equal(told({ lastFile: "a", lastTrouble: "no room" })?.text, "Not saved: no room");
});

test("while the last minutes are kept, both buttons are offered", () => {
  const ring = told({ state: State.RECORDING, ring: true, keepsLastS: 180, lastFile: "a.igs.mha" });
  assert.deepEqual(ring, { text: "Saved a.igs.mha", kind: "quiet", wish: Wish.START, keeps: true });
});
