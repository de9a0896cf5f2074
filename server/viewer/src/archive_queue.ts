// SPDX-License-Identifier: Apache-2.0
// The server's queue of stills for the archive.
import { callApi } from "./api";

export interface QueueState {
  available: boolean;
  waiting: number;
  refused: number;
}

/** Undefined where the server does not answer: it says why when a still is sent. */
export async function queueState(): Promise<QueueState | undefined> {
  try {
    return (await (await callApi("api/archive")).json()) as QueueState;
  } catch {
    return undefined;
  }
}
