// A view of this display's own: its light and its camera, while the others keep theirs.
import type { SceneState, ViewState } from "../generated/fanlight_pb.js";

/** Groups of fields that a display may have of its own; the others are the main view's. */
export const kOwnGroups: readonly string[] = ["camera", "filter", "light", "material", "shadow", "finish"];

export class OwnView {
  private readonly box: HTMLInputElement;
  private open = false;
  private main: SceneState | undefined;

  constructor(
    root: HTMLElement,
    private readonly events: { chosen(): void; leave(): void; backTo(main: SceneState): void },
  ) {
    const box = root.querySelector("input");
    if (!box) throw new Error("The page has no box for an own view.");
    this.box = box;
    box.onchange = () => (box.checked ? this.events.chosen() : this.left());
  }

  /** Whether changes are to be this display's alone. */
  get wanted(): boolean {
    return this.box.checked;
  }

  /** Whether the server has a private view of this display, which it has from the first change on. */
  get isOpen(): boolean {
    return this.open;
  }

  /** A session begins: it sees the main view. */
  forget(): void {
    this.box.checked = this.open = false;
  }

  mainIs(main: SceneState): void {
    this.main = main;
  }

  /** The server says what this display's view is; the reason where it has ended one. */
  tell(state: ViewState): string {
    // One that was opened by a change that was under way when it was left or ended.
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

  private back(): void {
    if (this.main) this.events.backTo(this.main);
  }
}
