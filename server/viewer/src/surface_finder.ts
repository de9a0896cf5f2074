// SPDX-License-Identifier: Apache-2.0
// The button "Find surface": asks the server for a scene that shows the surface of the last volume, and sets it.
import type { SurveyReply } from "../generated/fanlight_pb.js";
import { valuesOf, type Values } from "./scene";

export class SurfaceFinder {
  private asked = 0n; // number of the newest request; 0: none is unanswered
  private lastId = 0n;
  private last: Values | undefined;

  /** `say`: shows what was found until the next click; empty: nothing. */
  constructor(
    private readonly button: HTMLButtonElement,
    private readonly say: (sentence: string) => void,
    private readonly settings: { setFound(found: Values): void },
    ask: (requestId: bigint) => void,
  ) {
    button.onclick = () => {
      this.asked = this.lastId += 1n;
      button.ariaBusy = "true";
      this.say("");
      ask(this.asked);
    };
  }

  /** The scene of the last surface that was found. */
  get found(): Values | undefined {
    return this.last;
  }

  /** Call at the start of a session, and for another default scene: the last surface may be of another geometry. */
  reset(): void {
    this.last = undefined;
  }

  answered({ requestId, outcome }: SurveyReply): void {
    if (requestId !== this.asked) return;
    this.asked = 0n;
    this.button.ariaBusy = "false";
    if (outcome.case === "refused") this.say(outcome.value.message);
    if (outcome.case !== "found" || !outcome.value.scene) return;
    this.last = valuesOf(outcome.value.scene);
    this.settings.setFound(this.last);
    this.say(`Found ${outcome.value.choices.join("; ")}.`);
  }
}
