// SPDX-License-Identifier: Apache-2.0
// The queue of H.264 pictures before a decoder that is slow, fails, or is closed.
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { FilmDecoder } from "../src/film_decoder.js";
import type { Picture } from "../generated/fanlight_pb.js";

/** Stands in for the browser's decoder: it keeps what it gets, and the test says what comes out. */
class FakeDecoder {
  static made: FakeDecoder[] = [];
  state = "unconfigured";
  readonly timestamps: number[] = [];

  constructor(readonly to: { output: (frame: VideoFrame) => void; error: () => void }) {
    FakeDecoder.made.push(this);
  }
  configure(): void {
    this.state = "configured";
  }
  decode(chunk: { timestamp: number }): void {
    this.timestamps.push(chunk.timestamp);
  }
  close(): void {
    this.state = "closed";
  }
  /** Puts out the picture with this timestamp. */
  finish(timestamp: number): void {
    this.to.output({ timestamp, close: () => undefined } as unknown as VideoFrame);
  }
}

class FakeChunk {
  readonly timestamp: number;
  constructor(init: { timestamp: number }) {
    this.timestamp = init.timestamp;
  }
}

function picture(id: number, keyPicture = false): Picture {
  return { pictureId: BigInt(id), keyPicture, h264: new Uint8Array() } as unknown as Picture;
}

let shown: number[];
let failures: number;
let film: FilmDecoder;

beforeEach(() => {
  Object.assign(globalThis, { VideoDecoder: FakeDecoder, EncodedVideoChunk: FakeChunk });
  FakeDecoder.made = [];
  shown = [];
  failures = 0;
  film = new FilmDecoder(
    (_frame, of) => shown.push(Number(of.pictureId)),
    () => ++failures,
  );
});

/** The decoder that was made last. */
function newest(): FakeDecoder {
  const made = FakeDecoder.made.at(-1);
  assert.ok(made);
  return made;
}

test("pictures before the first key picture are not decoded", () => {
  film.decode(picture(1));
  assert.equal(FakeDecoder.made.length, 0);
  film.decode(picture(2, true));
  film.decode(picture(3));
  assert.deepEqual(newest().timestamps, [2, 3]);
});

test("each decoded picture is shown with its own description", () => {
  film.decode(picture(1, true));
  film.decode(picture(2));
  newest().finish(1);
  newest().finish(2);
  assert.deepEqual(shown, [1, 2]);
});

test("a decoder that falls 30 pictures behind is closed, and the queue is empty", () => {
  film.decode(picture(1, true));
  for (let id = 2; id <= 30; ++id) film.decode(picture(id));
  assert.equal(failures, 0);
  film.decode(picture(31));
  assert.equal(failures, 1);
  assert.equal(newest().state, "closed");
  film.decode(picture(32));
  assert.equal(FakeDecoder.made.length, 1, "a picture that depends on lost ones begins nothing");
  film.decode(picture(33, true));
  assert.equal(FakeDecoder.made.length, 2);
  assert.deepEqual(newest().timestamps, [33]);
});

test("a decoder that keeps up never falls behind", () => {
  film.decode(picture(1, true));
  newest().finish(1);
  for (let id = 2; id <= 500; ++id) {
    film.decode(picture(id));
    if (id % 20 === 0) newest().finish(id); // the ones before it were dropped by the decoder
  }
  assert.equal(failures, 0);
  assert.equal(newest().state, "configured");
});

test("an error of the decoder closes it", () => {
  film.decode(picture(1, true));
  newest().to.error();
  assert.equal(failures, 1);
  assert.equal(newest().state, "closed");
});
