// SPDX-License-Identifier: Apache-2.0
// Decodes H.264 pictures with WebCodecs, in the order of their arrival.
import type { Picture } from "../generated/fanlight_pb.js";

const kCodec = "avc1.42E01F"; // constrained baseline; without a description WebCodecs expects Annex B

// Pictures that wait for the decoder. One that is this far behind does not catch up.
const kMostPending = 30;

export function canDecodeFilm(): boolean {
  return "VideoDecoder" in window; // present only if the page came from localhost or over TLS
}

export class FilmDecoder {
  private decoder: VideoDecoder | undefined;
  private readonly pending = new Map<number, Picture>();

  constructor(
    private readonly decoded: (frame: VideoFrame, picture: Picture) => void,
    private readonly failed: () => void,
  ) {}

  decode(picture: Picture): void {
    if (!this.decoder) {
      if (!picture.keyPicture) return; // it depends on a picture that this decoder did not get
      this.decoder = this.begin();
    }
    if (this.pending.size >= kMostPending) {
      this.end();
      return this.failed();
    }
    const timestamp = Number(picture.pictureId);
    this.pending.set(timestamp, picture);
    const type = picture.keyPicture ? "key" : "delta";
    this.decoder.decode(new EncodedVideoChunk({ type, timestamp, data: picture.h264 }));
  }

  end(): void {
    if (this.decoder?.state !== "closed") this.decoder?.close();
    this.decoder = undefined;
    this.pending.clear();
  }

  private begin(): VideoDecoder {
    const decoder = new VideoDecoder({
      output: (frame) => {
        const picture = this.pending.get(frame.timestamp);
        for (const timestamp of this.pending.keys()) {
          if (timestamp <= frame.timestamp) this.pending.delete(timestamp);
        }
        if (picture) this.decoded(frame, picture);
        frame.close();
      },
      error: () => {
        this.end();
        this.failed();
      },
    });
    decoder.configure({ codec: kCodec, optimizeForLatency: true });
    return decoder;
  }
}
