// SPDX-License-Identifier: Apache-2.0
// The private view of this display: its own light and camera, while the other displays keep the main view.
import type { SceneState, ViewState } from "../generated/fanlight_pb.js";
import { kLamps } from "./lamps";
import type { Values } from "./scene";

/** Groups of fields that a display which lights surfaces may keep to itself: the server need not know them. */
export const kLitHere: readonly string[] = [...kLamps, "material", "shadow", "finish"];

/** Groups that a private view may change; the other groups follow the main view. */
export const kOwnGroups: readonly string[] = ["camera", "filter", ...kLitHere];

export class OwnView {
  private readonly box: HTMLInputElement;
  private open = false;
  private main: SceneState | undefined;
  private here: Values = new Map();

  constructor(
    root: HTMLElement,
    private readonly events: { chosen(): void; leave(): void; backTo(main: SceneState): void },
  ) {
    const box = root.querySelector("input");
    if (!box) throw new Error("The page has no box for an own view.");
    this.box = box;
    box.onchange = () => (box.checked ? this.events.chosen() : this.left());
  }

  /** Whether the user wants changes to affect this display only. */
  get wanted(): boolean {
    return this.box.checked;
  }

  /** Whether the server has a private view for this display. It opens one with the first change. */
  get isOpen(): boolean {
    return this.open;
  }

  /** Call at the start of a session, which begins with the main view. */
  forget(): void {
    this.box.checked = this.open = false;
    this.here.clear();
  }

  /** Keeps those of the values that this display can show without the server. Returns the others. */
  keep(values: Values): Values {
    const isHere = (name: string) => kLitHere.includes(name.split(".")[0]!);
    for (const [name, value] of values) if (isHere(name)) this.here.set(name, value);
    return new Map([...values].filter(([name]) => !isHere(name)));
  }

  /** The scene of the server with what this display keeps. */
  over(values: Values): Values {
    return this.wanted ? new Map([...values, ...this.here]) : values;
  }

  /** What this display has kept and the server has to know from now on, since it draws the pictures. */
  giveBack(): Values {
    const values = this.here;
    this.here = new Map();
    return values;
  }

  mainIs(main: SceneState): void {
    this.main = main;
  }

  /** Takes the server's state of the private view. Returns a sentence if the server has ended it, else empty. */
  tell(state: ViewState): string {
    // A change that was in flight when the view was left has opened it again: leave it again.
    if (state.isPrivate && !this.box.checked) this.events.leave();
    this.open = state.isPrivate && this.box.checked;
    if (!state.ended || !this.box.checked || state.isPrivate) return "";
    this.box.checked = false;
    this.back();
    return `Your own view has ended: ${state.ended}.`;
  }

  private left(): void {
    if (this.open) this.events.leave();
    this.open = false;
    this.back();
  }

  /** Ends it: the server cannot draw it. */
  end(): void {
    this.box.checked = false;
    this.left();
  }

  private back(): void {
    this.here.clear();
    if (this.main) this.events.backTo(this.main);
  }
}
