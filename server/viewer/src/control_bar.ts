// SPDX-License-Identifier: Apache-2.0
// Shows which session holds control, and the one action that this display can take about it.
import { ControlRequest_Wish as Wish, Role, type ControlState } from "../generated/fanlight_pb.js";

export interface ControlText {
  text: string;
  /** Label and request of the button; absent: no button. */
  offer?: { label: string; wish: Wish; toSession?: bigint };
  /** Whether this display may change anything now. */
  mayChange: boolean;
}

export function controlText(state: ControlState, role: Role, session: bigint): ControlText {
  const free = state.holderSession === 0n;
  const holder = display(state.holderName, state.holderSession);
  if (role === Role.VIEWER) {
    return { text: free ? "Watching" : `Watching; ${holder} is in control`, mayChange: false };
  }
  if (free) return { text: "", mayChange: true };
  if (state.mine) {
    const first = state.asking[0];
    return first
      ? {
          text: `${display(first.name, first.session)} asks for the control`,
          offer: { label: "Hand over", wish: Wish.GRANT, toSession: first.session },
          mayChange: true,
        }
      : { text: "You control", offer: { label: "Release", wish: Wish.RELEASE }, mayChange: true };
  }
  const text = `${holder} is in control`;
  if (role === Role.ADMIN) return { text, offer: { label: "Take over", wish: Wish.TAKE_OVER }, mayChange: false };
  const asked = state.asking.some((one) => one.session === session);
  return asked
    ? { text: `${text}; requested`, offer: { label: "Cancel request", wish: Wish.RELEASE }, mayChange: false }
    : { text, offer: { label: "Request control", wish: Wish.ASK }, mayChange: false };
}

/** Several displays may use one token and so have one name; the session number distinguishes them. */
function display(name: string, session: bigint): string {
  return `${name} (display ${session})`;
}

export class ControlBar {
  private readonly text: Element;
  private readonly button: HTMLButtonElement;

  constructor(
    private readonly root: HTMLElement,
    private readonly send: (wish: Wish, toSession: bigint) => void,
  ) {
    const [text, button] = root.children;
    if (!text || !(button instanceof HTMLButtonElement)) throw new Error("The page has no place for the control.");
    [this.text, this.button] = [text, button];
  }

  show({ text, offer }: ControlText): void {
    this.root.hidden = text === "";
    this.text.textContent = text;
    this.button.hidden = !offer;
    this.button.textContent = offer?.label ?? "";
    this.button.onclick = () => offer && this.send(offer.wish, offer.toSession ?? 0n);
  }
}
