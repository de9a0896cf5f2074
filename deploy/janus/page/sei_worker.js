// SPDX-License-Identifier: Apache-2.0
// Passes each encoded picture on as it is, and tells the page what is said of it.
import { pictureData } from "./picture_data.js";

self.onrtctransform = ({ transformer }) => {
  const read = new TransformStream({
    transform(frame, controller) {
      const data = pictureData(new Uint8Array(frame.data));
      if (data) postMessage({ timestamp: frame.getMetadata().rtpTimestamp ?? frame.timestamp, data });
      controller.enqueue(frame);
    },
  });
  transformer.readable.pipeThrough(read).pipeTo(transformer.writable);
};
