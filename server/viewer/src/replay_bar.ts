// SPDX-License-Identifier: Apache-2.0
// The bar that controls the replay of a recording: play, step, place, speed, and what follows the last frame.
import {
  ReplayRequest_Wish as Wish,
  ReplayStatus_Ending as Ending,
  ReplayStatus_State as State,
  type ReplayStatus,
} from "../generated/fanlight_pb.js";

const kDragMs = 100; // a dragged slider asks no more often

export interface ReplayWish {
  wish: Wish;
  value?: number;
  ending?: Ending;
}

/** "3.2 of 7.9 s, sweep 4 of 21", and why it stopped. */
export function replayText(status: ReplayStatus): string {
  const place = `${status.timeS.toFixed(1)} of ${status.durationS.toFixed(1)} s`;
  const sweep = `sweep ${status.sweep + 1} of ${status.sweeps}`;
  const back = status.backward ? ", backward" : "";
  const end = status.state === State.ENDED ? ", ended" : "";
  return `${place}, ${sweep}${back}${end}`;
}

/** What the main button asks for. */
export function mainWish(status: ReplayStatus): Wish {
  return status.state === State.PLAYING ? Wish.PAUSE : Wish.PLAY;
}

export class ReplayBar {
  private readonly main: HTMLButtonElement;
  private readonly place: HTMLInputElement;
  private readonly text: Element;
  private readonly speed: HTMLSelectElement;
  private readonly ending: HTMLSelectElement;
  private readonly trouble: Element;
  private lastId = 0n;
  private askedMs = 0;
  private dragging = false;
  private asked = ""; // the last place asked for

  constructor(
    private readonly root: HTMLElement,
    private readonly send: (requestId: bigint, wish: ReplayWish) => void,
  ) {
    const part = <T extends Element>(name: string): T => root.querySelector<T>(`[data-replay="${name}"]`)!;
    this.main = part("main");
    this.place = part("place");
    this.text = part("text");
    this.speed = part("speed");
    this.ending = part("ending");
    this.trouble = part("trouble");
    this.main.onclick = () => this.ask({ wish: Number(this.main.value) as Wish });
    part<HTMLButtonElement>("back").onclick = () => this.ask({ wish: Wish.STEP, value: -1 });
    part<HTMLButtonElement>("forward").onclick = () => this.ask({ wish: Wish.STEP, value: 1 });
    this.speed.onchange = () => this.ask({ wish: Wish.SPEED, value: Number(this.speed.value) });
    this.ending.onchange = () => this.ask({ wish: Wish.ENDING, ending: Number(this.ending.value) as Ending });
    this.place.oninput = () => this.drag(performance.now());
    this.place.onchange = () => this.drop();
    this.place.onpointerup = this.place.onpointercancel = this.place.onblur = () => (this.dragging = false);
  }

  /** Whether a recording is played. */
  get isShown(): boolean {
    return !this.root.hidden;
  }

  tell(status: ReplayStatus): void {
    this.root.hidden = status.state === State.NO_RECORDING;
    if (this.root.hidden) return;
    write(this.text, replayText(status));
    write(this.trouble, status.trouble);
    const wish = mainWish(status);
    this.main.value = String(wish);
    write(this.main, wish === Wish.PAUSE ? "Pause" : "Play");
    this.place.max = String(status.durationS);
    if (!this.dragging) this.place.value = String(status.timeS);
    this.place.ariaValueText = replayText(status);
    choose(this.speed, String(status.speed), `${status.speed} x`);
    choose(this.ending, String(status.ending), "");
  }

  /** Whether this display may control the replay now. */
  allow(may: boolean): void {
    for (const control of this.root.querySelectorAll<HTMLButtonElement>("button, input, select"))
      control.disabled = !may;
    if (!may) this.dragging = false;
  }

  private drag(nowMs: number): void {
    this.dragging = true;
    if (nowMs - this.askedMs < kDragMs) return;
    this.askedMs = nowMs;
    this.seek();
  }

  private drop(): void {
    this.dragging = false;
    if (this.place.value !== this.asked) this.seek(); // a key has asked already
  }

  private seek(): void {
    this.asked = this.place.value;
    this.ask({ wish: Wish.SEEK, value: Number(this.place.value) });
  }

  private ask(wish: ReplayWish): void {
    this.send((this.lastId += 1n), wish);
  }
}

/** Writes only changed text, because a screen reader announces every write. */
function write(place: Element, text: string): void {
  if (place.textContent !== text) place.textContent = text;
}

/** Chooses a value, which another display may have set to one that the list lacks. */
function choose(list: HTMLSelectElement, value: string, label: string): void {
  if (document.activeElement === list && list.value === value) return;
  if (![...list.options].some((option) => option.value === value)) list.add(new Option(label, value));
  list.value = value;
}
