// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { Liveness_Cause, Liveness_Origin, Liveness_State, LivenessSchema } from "../generated/fanlight_pb.js";
import { ageText, LivenessWatch, markText, stateWord } from "../src/liveness";

const kServerAheadMs = 100_000;
const serverMs = (pageMs: number) => pageMs + kServerAheadMs;

function told(state: Liveness_State, cause = Liveness_Cause.NONE, sentence = "", limitS = 2) {
  return create(LivenessSchema, { state, cause, sentence, limitS });
}

/** A page that heard the server at `nowMs`, and shows a volume captured 300 ms before. */
function watchAt(nowMs: number): LivenessWatch {
  const watch = new LivenessWatch(serverMs);
  watch.reset(nowMs);
  watch.tell(told(Liveness_State.LIVE));
  watch.show(serverMs(nowMs - 300));
  return watch;
}

test("a young picture of a server that says live is live", () => {
  assert.deepEqual(watchAt(1000).news(1000), { state: "live", ageMs: 300, title: "", detail: "" });
});

test("without a picture the page waits, and says what keeps it away", () => {
  const watch = new LivenessWatch(serverMs);
  watch.reset(0);
  assert.deepEqual(watch.news(100), { state: "waiting", ageMs: undefined, title: "", detail: "" });
  watch.tell(told(Liveness_State.WAITING, Liveness_Cause.NO_FRAMES, "The source has sent no frame for 3 s."));
  const news = watch.news(200);
  assert.deepEqual([news.state, news.title], ["waiting", "No new frames"]);
  assert.equal(news.detail, "The source has sent no frame for 3 s.");
});

test("each cause from the server has a title, and removes the word live at once", () => {
  for (const cause of Object.values(Liveness_Cause).filter(
    (value): value is Liveness_Cause => typeof value === "number",
  )) {
    // Reported beside any state, and removes none: see below.
    if (cause === Liveness_Cause.NONE || cause === Liveness_Cause.CHANGE_NOT_SHOWN) continue;
    const watch = watchAt(1000);
    watch.tell(told(Liveness_State.NOT_LIVE, cause, "A reason."));
    const news = watch.news(1000);
    assert.equal(news.state, "not-live");
    assert.ok(news.title.length > 0, `cause ${cause} has no title`);
    assert.equal(news.detail, "A reason.");
  }
});

test("a change that is not shown is reported beside live, frozen and replayed pictures", () => {
  const sentences: [Liveness_State, string, string][] = [
    [Liveness_State.LIVE, "The picture is live.", "live"],
    [Liveness_State.FROZEN, "The picture is frozen.", "frozen"],
    [Liveness_State.REPLAY, "A recording is played.", "replay"],
  ];
  for (const [state, sentence, expected] of sentences) {
    const watch = watchAt(1000);
    const why = "The last change is not shown, because the GPU cannot draw it: no memory.";
    const cause = Liveness_Cause.CHANGE_NOT_SHOWN;
    watch.tell(create(LivenessSchema, { state, cause, sentence: `${sentence} ${why}`, sceneTrouble: why, limitS: 2 }));
    const news = watch.news(1000);
    assert.deepEqual([news.state, news.title, news.detail], [expected, "Settings not applied", why]);
  }
});

test("a live picture says where its frames come from, where that is no known probe", () => {
  const watch = watchAt(1000);
  const wordOf = (origin: Liveness_Origin) => {
    watch.tell(create(LivenessSchema, { state: Liveness_State.LIVE, origin, limitS: 2 }));
    return stateWord(watch.news(1000));
  };
  assert.equal(wordOf(Liveness_Origin.PROBE), "Live");
  assert.equal(wordOf(Liveness_Origin.UNKNOWN), "Live, unverified");
  assert.equal(wordOf(Liveness_Origin.SIMULATED), "Simulated");
});

test("the last picture of a recording is not lost after its end", () => {
  const watch = watchAt(1000);
  watch.tell({ ...told(Liveness_State.NOT_LIVE, Liveness_Cause.SOURCE_ENDED), origin: Liveness_Origin.RECORDING });
  const { state, title, detail } = watch.news(1000);
  assert.deepEqual([state, title, detail], ["ended", "The recording has ended", "The last volume is still shown."]);
  assert.equal(markText(watch.news(1000)), "Replay ended");
});

test("a sentence does not say again what its title says", () => {
  const watch = watchAt(1000);
  const detail = (cause: Liveness_Cause, sentence: string) => {
    watch.tell(told(Liveness_State.NOT_LIVE, cause, sentence));
    return watch.news(1000).detail;
  };
  assert.equal(detail(Liveness_Cause.SOURCE_ENDED, "The recording has ended."), "");
  assert.equal(detail(Liveness_Cause.GPU_HUNG, "The GPU does not answer: nothing for 10 s."), "nothing for 10 s.");
});

test("a cause that this page does not know still takes the word live away", () => {
  const watch = watchAt(1000);
  watch.tell(told(Liveness_State.NOT_LIVE, 99 as Liveness_Cause, "Something new."));
  assert.deepEqual([watch.news(1000).state, watch.news(1000).title], ["not-live", "No new pictures"]);
});

test("a server that says nothing for two seconds does not answer", () => {
  const watch = watchAt(1000);
  watch.show(serverMs(4000)); // the picture itself is no message of the server
  assert.equal(watch.news(2999).state, "live");
  const news = watch.news(3100);
  assert.deepEqual([news.state, news.title], ["not-live", "The server does not answer"]);
  assert.equal(news.detail, "No data for 2 s.");
  watch.heard(3200);
  assert.equal(watch.news(3300).state, "live");
});

test("pictures that reach this display late are delayed, though the server's are live", () => {
  const watch = watchAt(1000);
  for (let nowMs = 1000; nowMs <= 9000; nowMs += 500) watch.heard(nowMs);
  watch.show(serverMs(5500));
  const news = watch.news(9000);
  assert.deepEqual([news.state, news.ageMs, news.title], ["delayed", 3500, "Delayed"]);
  watch.tell(told(Liveness_State.LIVE, Liveness_Cause.NONE, "", 9)); // sweeps of three seconds
  assert.equal(watch.news(9100).state, "delayed", "the word does not flicker");
  watch.heard(12_000);
  assert.equal(watch.news(12_100).state, "live");
});

test("a relit old volume stays old", () => {
  const watch = watchAt(1000);
  for (let nowMs = 1000; nowMs <= 9000; nowMs += 500) {
    watch.heard(nowMs);
    watch.show(serverMs(700));
  }
  assert.equal(watch.news(9000).ageMs, 8300);
  assert.equal(watch.news(9000).state, "delayed");
});

test("while the clock is unknown the page believes the server", () => {
  const watch = new LivenessWatch(() => undefined);
  watch.reset(0);
  watch.show(5);
  watch.tell(told(Liveness_State.LIVE));
  assert.deepEqual(watch.news(10), { state: "live", ageMs: undefined, title: "", detail: "" });
});

test("ages are short, and marks say what is wrong", () => {
  assert.deepEqual(
    [ageText(undefined), ageText(420), ageText(48_900), ageText(125_000)],
    ["", "0.4 s", "48 s", "2 min"],
  );
  const mark = (state: "live" | "delayed" | "not-live", ageMs?: number) =>
    markText({ state, ageMs, title: "", detail: "" });
  assert.equal(mark("live", 10), "");
  assert.equal(mark("delayed", 3100), "Delayed 3.1 s");
  assert.equal(mark("not-live", 48_900), "Lost, 48 s old");
  assert.equal(mark("not-live", 3 * 3_600_000), "Lost, 3 h old");
  assert.equal(mark("not-live"), "Lost");
});

test("a frozen picture is frozen, with its age, whatever becomes of the source", () => {
  const watch = watchAt(1000);
  watch.show(serverMs(400));
  watch.tell(told(Liveness_State.FROZEN, Liveness_Cause.PROBE_LOST, "The picture is frozen. The probe is lost."));
  const news = watch.news(1000);
  assert.deepEqual([news.state, news.ageMs, news.title], ["frozen", 600, "Probe lost"]);
  assert.equal(markText(news), "Frozen, 0 s old");
});

test("a picture that was frozen is so until a new one replaces it, for three seconds at most", () => {
  const watch = watchAt(1000);
  watch.tell(told(Liveness_State.FROZEN), 1000);
  for (let nowMs = 1000; nowMs <= 200_000; nowMs += 1000) watch.heard(nowMs);
  watch.tell(told(Liveness_State.LIVE), 200_000);
  assert.equal(watch.news(200_100).state, "frozen");
  watch.show(serverMs(200_000));
  assert.equal(watch.news(200_200).state, "live", "it was not delayed");
  watch.heard(203_500);
  watch.hold(true, 200_300);
  watch.hold(false, 203_400);
  assert.equal(watch.news(203_500).state, "frozen");
  watch.heard(207_000);
  assert.equal(watch.news(207_000).state, "delayed", "no new picture has come");
  watch.tell(told(Liveness_State.FROZEN), 207_000);
  watch.tell(told(Liveness_State.REPLAY), 207_100);
  assert.equal(watch.news(207_200).state, "replay", "its age says nothing");
});
