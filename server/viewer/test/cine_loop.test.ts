// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { create } from "@bufbuild/protobuf";
import { CineStatus_State as State, CineStatusSchema } from "../generated/fanlight_pb.js";
import { CineLoop } from "../src/cine_loop";

/** Four volumes, of which the third took long. */
const kTimesS = [0, 0.1, 0.2, 5];

function machine() {
  let nowMs = 1000;
  let lost = false;
  let due: { atMs: number; run: () => void } | undefined;
  const seen: string[] = [];
  const loop = new CineLoop(
    {
      has: (volumeId) => !lost || volumeId !== 12n,
      show: (volumeId) => {
        seen.push(`${volumeId - 10n}:${volumeId}`);
        return !lost;
      },
    },
    {
      nowMs: () => nowMs,
      runIn: (ms, run) => void (due = run && { atMs: nowMs + ms, run }),
    },
  );
  const tell = (volume: number, state = State.FROZEN, speed = 1) =>
    loop.tell(
      create(CineStatusSchema, {
        state,
        volumes: kTimesS.length,
        volume,
        volumeId: BigInt(10 + volume),
        timeS: kTimesS[volume]!,
        durationS: kTimesS.at(-1)!,
        speed,
      }),
    );
  const pass = (ms: number) => {
    const endMs = nowMs + ms;
    while (due && due.atMs <= endMs) {
      const { atMs, run } = due;
      due = undefined;
      nowMs = Math.max(nowMs, atMs);
      run();
    }
    nowMs = Math.max(nowMs, endMs);
  };
  const taken = () => seen.splice(0);
  return { loop, tell, pass, taken, lose: () => (lost = true), hold: (ms: number) => (nowMs += ms) };
}

test("volumes that were all on show are played at the rate at which they were captured", () => {
  const { loop, tell, pass, taken } = machine();
  for (const volume of [3, 2, 1]) tell(volume);
  assert.deepEqual([loop.numberOf(12n), loop.numberOf(10n)], [2, undefined]);
  tell(3, State.PLAYING);
  assert.equal(loop.volume, undefined, "the first one was not on show yet");
  tell(0, State.PLAYING);
  assert.deepEqual(taken(), ["0:10"]);
  pass(90);
  assert.deepEqual(taken(), []);
  pass(120);
  assert.deepEqual(taken(), ["1:11", "2:12"]);
  pass(1000); // a pause of the source is not waited for
  assert.deepEqual(taken(), ["3:13"]);
  pass(1000); // the last one stays as long as the others on average, and a second at most
  assert.deepEqual(taken(), ["0:10"]);
  tell(1, State.PLAYING); // the server is elsewhere
  assert.equal(loop.volume, 0);
});

test("the loop takes another speed, ends with the server's, and where a volume is not there any more", () => {
  const { loop, tell, pass, taken, lose, hold } = machine();
  for (const volume of [0, 1, 2, 3]) tell(volume);
  tell(0, State.PLAYING);
  tell(0, State.PLAYING, 0.5);
  pass(190);
  assert.deepEqual(taken(), ["0:10"]);
  pass(20);
  assert.deepEqual(taken(), ["1:11"]);
  hold(60_000);
  pass(10);
  assert.equal(taken().length, 1, "one volume after a long wait");
  tell(2);
  assert.equal(loop.volume, undefined);
  pass(3000);
  assert.deepEqual(taken(), []);
  tell(2, State.PLAYING, 0.1);
  assert.deepEqual(taken(), ["2:12"]);
  tell(2, State.PLAYING, 4);
  pass(260);
  assert.deepEqual(taken(), ["3:13"], "a quicker loop does not wait for the slow one");
  lose();
  pass(2000);
  assert.deepEqual(taken(), ["0:10"]);
  assert.equal(loop.volume, undefined);
  tell(2, State.PLAYING);
  assert.deepEqual(taken(), [], "one of the volumes is not there any more");
  tell(0, State.LIVE);
  assert.equal(loop.of(0), undefined);
});
