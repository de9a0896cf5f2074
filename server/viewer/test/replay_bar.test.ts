// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create, type MessageInitShape } from "@bufbuild/protobuf";
import {
  Liveness_State,
  LivenessSchema,
  ReplayRequest_Wish as Wish,
  ReplayStatus_State as State,
  ReplayStatusSchema,
} from "../generated/fanlight_pb.js";
import { LivenessWatch, markText, stateWord } from "../src/liveness";
import { mainWish, replayText } from "../src/replay_bar";

function status(change: MessageInitShape<typeof ReplayStatusSchema>) {
  return create(ReplayStatusSchema, {
    state: State.PLAYING,
    timeS: 3.24,
    durationS: 7.9,
    sweep: 3,
    sweeps: 21,
    ...change,
  });
}

test("the place in the recording is shown in seconds and sweeps", () => {
  assert.equal(replayText(status({})), "3.2 of 7.9 s, sweep 4 of 21");
  assert.equal(replayText(status({ backward: true })), "3.2 of 7.9 s, sweep 4 of 21, backward");
  assert.equal(replayText(status({ state: State.ENDED })), "3.2 of 7.9 s, sweep 4 of 21, ended");
});

test("the main button pauses what plays, and else plays", () => {
  assert.equal(mainWish(status({})), Wish.PAUSE);
  for (const state of [State.PAUSED, State.ENDED, State.FAILED]) assert.equal(mainWish(status({ state })), Wish.PLAY);
});

test("a replay is marked on its picture, however old that is", () => {
  const watch = new LivenessWatch((pageMs) => pageMs);
  watch.reset(0);
  watch.show(0);
  watch.tell(create(LivenessSchema, { state: Liveness_State.REPLAY, limitS: 2 }));
  for (const nowMs of [100, 60_000]) {
    watch.heard(nowMs);
    const news = watch.news(nowMs);
    assert.equal(stateWord(news), "Replay");
    assert.equal(markText(news), "Replay");
    assert.equal(news.title, "");
  }
});
