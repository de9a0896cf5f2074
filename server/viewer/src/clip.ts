// SPDX-License-Identifier: Apache-2.0
// Puts H.264 pictures into an MP4 file as they came, without encoding them again. A script of its own, which the page
// loads when a clip ends. mediabunny (MPL 2.0) knows the format; it is kept up and has no code that the page needs twice.
import { BufferTarget, EncodedPacket, EncodedVideoPacketSource, Mp4OutputFormat, Output } from "mediabunny";

export interface ClipPicture {
  h264: Uint8Array;
  isKey: boolean;
  /** When the server had finished it. */
  timeS: number;
  width: number;
  height: number;
}

const kLastPictureS = 0.5; // it is not known how long the last one was on show

/** The first picture must be a key picture. */
export async function mp4Of(pictures: readonly ClipPicture[]): Promise<Blob> {
  const [first] = pictures;
  if (!first) throw new Error("The clip has no picture.");
  const output = new Output({ format: new Mp4OutputFormat({ fastStart: "in-memory" }), target: new BufferTarget() });
  const source = new EncodedVideoPacketSource("avc");
  output.addVideoTrack(source);
  await output.start();
  // Without a description the bytes are taken as Annex B, as the server sends them.
  const decoderConfig = { codec: "avc1.42E01F", codedWidth: first.width, codedHeight: first.height };
  for (const [index, { h264, isKey, timeS }] of pictures.entries()) {
    const next = pictures[index + 1];
    const packet = new EncodedPacket(
      h264,
      isKey ? "key" : "delta",
      timeS - first.timeS,
      next ? next.timeS - timeS : kLastPictureS,
    );
    await source.add(packet, index === 0 ? { decoderConfig } : undefined);
  }
  await output.finalize();
  return new Blob([output.target.buffer!], { type: "video/mp4" });
}
