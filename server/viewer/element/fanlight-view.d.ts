// SPDX-License-Identifier: Apache-2.0
// Types of <fanlight-view>. Importing the package defines the element.

/** Of "fanlight-picture": the picture that is shown now. */
export interface FanlightPicture {
  pictureId: bigint;
  volumeId: bigint;
  sceneRevision: bigint;
  /** Of the last frame of the volume, on the clock of the server. */
  captureTimeNs: bigint;
  width: number;
  height: number;
}

/** Of "fanlight-state", when it changes. */
export interface FanlightState {
  /** "refused": a wrong attribute, or no access. The element does not try again before an attribute changes. */
  state:
    | "connecting"
    | "waiting"
    | "live"
    | "delayed"
    | "not-live"
    | "replay"
    | "ended"
    | "frozen"
    | "lost"
    | "refused";
  /** As the element shows it, such as "Simulated". */
  word: string;
  /** What keeps pictures away, and the sentence about it; both empty where nothing does. */
  title: string;
  detail: string;
}

export interface FanlightViewElement extends HTMLElement {
  /** Not written to the document. Replaces the attribute "token"; empty: the attribute counts again. */
  token: string;
  addEventListener(
    type: "fanlight-picture",
    listener: (event: CustomEvent<FanlightPicture>) => void,
    options?: boolean | AddEventListenerOptions,
  ): void;
  addEventListener(
    type: "fanlight-state",
    listener: (event: CustomEvent<FanlightState>) => void,
    options?: boolean | AddEventListenerOptions,
  ): void;
  addEventListener<Type extends keyof HTMLElementEventMap>(
    type: Type,
    listener: (event: HTMLElementEventMap[Type]) => void,
    options?: boolean | AddEventListenerOptions,
  ): void;
}

declare global {
  interface HTMLElementTagNameMap {
    "fanlight-view": FanlightViewElement;
  }
}
