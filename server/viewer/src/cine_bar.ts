// SPDX-License-Identifier: Apache-2.0
// Freezes the display, and shows the last volumes that the server keeps.
import { CineLoop } from "./cine_loop";
import {
  CineRequest_Wish as Wish,
  CineStatus_State as State,
  type CineRequest,
  type CineStatus,
} from "../generated/fanlight_pb.js";

const kDragMs = 100; // a dragged slider asks no more often
const kAnswerMs = 1500; // the server has answered by then
const kBehindMs = 10_000; // what is not drawn by then does not come

/** "volume 3 of 20", ", 1.4 s before the newest": a small screen has no room for the second part. */
export function cineTexts({
  volume,
  volumes,
  timeS,
  durationS,
}: Pick<CineStatus, "volume" | "volumes" | "timeS" | "durationS">): [place: string, time: string] {
  const isNewest = volume + 1 >= volumes;
  const time = isNewest ? "" : `, ${(durationS - timeS).toFixed(1)} s before the newest`;
  return [`volume ${volume + 1} of ${volumes}`, time];
}

/** The fields that a wish needs; the others keep their defaults. */
export type CineWish = Pick<CineRequest, "requestId" | "wish" | "value" | "volumeId">;

export interface KeptVolumes {
  /** Of the picture on show; 0: none yet. */
  shownId(): bigint;
  /** Whether this display has it. */
  has(volumeId: bigint): boolean;
  /** 0: a volume that was not on show. */
  show(volumeId: bigint): void;
  /** The server is asked to freeze this volume, which is on show; 0: none is. */
  stayAt(volumeId: bigint): void;
  /** Whether it could. */
  loop(volumeId: bigint): boolean;
  endLoop(): void;
  /** The server shows this volume; 0: a new one. */
  endLoopAt(volumeId: bigint): void;
  /** Whether new volumes are shown: frozen ones that are still on their way then do not replace a newer one. */
  setLive(live: boolean): void;
  /** The server has frozen this one. */
  frozenAt(volumeId: bigint): void;
}

export class CineBar {
  private readonly freeze: HTMLButtonElement;
  private readonly bar: HTMLElement;
  private readonly main: HTMLButtonElement;
  private readonly place: HTMLInputElement;
  private readonly text: Element;
  private readonly speed: HTMLSelectElement;
  private status: CineStatus | undefined;
  private dragging = false;
  private askedMs = 0;
  private readonly loop: CineLoop;
  private expected: number | undefined; // which is asked for and not on show yet
  private expectedMs = 0; // since when
  private lastId = 0n;
  private mayAsk = false;
  private held = false;
  private movedMs = 0; // when the server has moved to the volume of its status
  /** What is frozen is the replay of a recording, not live. */
  isReplay = false;

  /**
   * `hold`: keeps the picture of this display alone, for those who may not freeze that of all. `kept`: shows a volume
   * that was on show before, if this display has kept it: until the server shows it, or, in a loop, whatever the server
   * shows.
   */
  constructor(
    root: HTMLElement,
    private readonly send: (wish: CineWish) => void,
    private readonly hold: (held: boolean) => void,
    private readonly kept: KeptVolumes,
  ) {
    this.loop = new CineLoop({
      has: (volumeId) => this.kept.has(volumeId),
      show: (volumeId) => {
        const shown = this.kept.loop(volumeId);
        if (shown) this.showPlace();
        return shown;
      },
    });
    const part = <T extends Element>(name: string): T => root.querySelector<T>(`[data-cine="${name}"]`)!;
    this.freeze = part("freeze");
    this.bar = part("bar");
    this.main = part("main");
    this.place = part("place");
    this.text = part("text");
    this.speed = part("speed");
    this.freeze.onclick = () => this.toggle();
    this.main.onclick = () => this.playOrPause();
    part<HTMLButtonElement>("back").onclick = () => this.step(-1);
    part<HTMLButtonElement>("forward").onclick = () => this.step(1);
    this.place.oninput = () => this.drag(performance.now());
    this.place.onchange = () => this.seek(this.place.valueAsNumber);
    this.place.onpointerup = this.place.onpointercancel = this.place.onblur = () => (this.dragging = false);
    this.speed.onchange = () => this.ask(Wish.SPEED, Number(this.speed.value));
  }

  get mayFreeze(): boolean {
    return this.mayAsk;
  }

  /** Frozen on one volume: it can be measured. */
  get isStill(): boolean {
    return this.status?.state === State.FROZEN;
  }

  /** This display alone keeps its picture. */
  get isHeld(): boolean {
    return this.held;
  }

  get isFrozen(): boolean {
    return this.status !== undefined && this.status.state !== State.LIVE;
  }

  /** The server has moved to a frozen volume whose picture is not here yet. For a while: it may refuse to draw it. */
  get isBehind(): boolean {
    const isElsewhere = this.isStill && !this.held && this.status!.volumeId !== this.kept.shownId();
    return isElsewhere && performance.now() - this.movedMs < kBehindMs;
  }

  /** Call for each picture shown. */
  pictureShown(): void {
    if (this.isFrozen) this.showPlace();
  }

  /** Freezes all displays, or shows new volumes on them; where that is not allowed, this display alone. */
  toggle(): void {
    if (this.freeze.disabled) return;
    if (this.held || !this.mayAsk) return this.holdHere(!this.held);
    if (this.isFrozen) this.ask(Wish.LIVE);
    else this.freezeShown();
  }

  /** Stops at one volume, whatever is shown. */
  still(): void {
    if (!this.mayAsk || this.isStill) return;
    if (this.isFrozen) this.playOrPause();
    else this.freezeShown();
  }

  /** Call at the start of a session. */
  start(): void {
    this.loop.forget();
    this.kept.endLoop();
    this.expected = undefined;
    this.isReplay = false;
    this.holdHere(false);
  }

  step(volumes: number): void {
    if (!this.isFrozen) return;
    const { volumes: count, volume } = this.status!;
    const next = ((((this.expected ?? this.loop.volume ?? volume) + volumes) % count) + count) % count;
    if (this.loop.volume !== undefined) return this.seek(next); // the server shows another one
    this.ask(Wish.STEP, volumes);
    this.expect(next);
  }

  playOrPause(): void {
    if (!this.isFrozen) return;
    if (this.loop.volume !== undefined) return this.seek(this.loop.volume);
    this.ask(this.status?.state === State.PLAYING ? Wish.PAUSE : Wish.PLAY);
  }

  tell(status: CineStatus): void {
    // What was on its way when this display asked for a volume says nothing.
    const isBefore = this.expected !== undefined && performance.now() - this.expectedMs < kAnswerMs;
    const wasLooping = this.loop.volume !== undefined;
    if (status.state !== State.PLAYING || !isBefore) {
      this.loop.tell(status);
      if (wasLooping && this.loop.volume === undefined) this.kept.endLoopAt(status.volumeId);
      if (status.state !== State.FROZEN || status.volume === this.expected) this.expected = undefined;
    }
    const isLive = status.state === State.LIVE;
    if (this.isFrozen === isLive) {
      this.kept.setLive(isLive);
      if (!isLive) this.kept.frozenAt(status.volumeId);
    }
    if (status.volumeId !== this.status?.volumeId) this.movedMs = performance.now();
    this.status = status;
    this.showFreeze();
    this.bar.hidden = !this.isFrozen;
    if (!this.isFrozen) return;
    write(this.main, status.state === State.PLAYING ? "Pause" : "Play");
    this.showPlace();
    this.allow(this.mayAsk);
    if (document.activeElement !== this.speed) this.speed.value = String(status.speed);
  }

  /** The server may have a newer volume already: what the user saw stays, and pictures on their way are dropped. */
  private freezeShown(): void {
    const shownId = this.kept.shownId();
    this.ask(Wish.FREEZE, 0, shownId);
    this.kept.stayAt(shownId);
  }

  /** Which volume is on show here: that of the picture, which may come after the server's word. */
  private showPlace(): void {
    if (!this.status) return;
    const volume = this.loop.volume ?? this.loop.numberOf(this.kept.shownId()) ?? this.status.volume;
    const shown = { ...this.status, volume, timeS: this.loop.of(volume)?.timeS ?? this.status.timeS };
    const texts = cineTexts(shown);
    texts.forEach((text, index) => write(this.text.children[index]!, text));
    this.place.max = String(shown.volumes - 1);
    if (!this.dragging) this.place.value = String(shown.volume);
    this.place.ariaValueText = texts.join("");
  }

  /** Whether this display may freeze all displays now; `open`: there is a session. */
  allow(may: boolean, open = may): void {
    this.mayAsk = may;
    // What is frozen for all cannot be frozen once more here.
    this.freeze.disabled = !(may || (open && (this.held || !this.isFrozen)));
    this.showFreeze();
    const single = (this.status?.volumes ?? 0) < 2; // there is nothing to step to
    for (const control of this.bar.querySelectorAll<HTMLButtonElement>("[data-cine]"))
      control.disabled = !may || single;
  }

  private holdHere(held: boolean): void {
    this.held = held;
    this.hold(held);
    this.showFreeze(); // the page shows the state several times a second anyway
  }

  private showFreeze(): void {
    const frozen = this.held || this.isFrozen;
    this.freeze.ariaPressed = String(frozen);
    write(
      this.freeze,
      frozen ? (this.isReplay ? "Back to the replay" : "Live again") : this.mayAsk ? "Freeze" : "Freeze here",
    );
    const whose = this.mayAsk && !this.held ? "for all displays" : "on this display only";
    this.freeze.title = frozen ? "Show new pictures again (Space)" : `Freeze the picture ${whose} (Space)`;
  }

  private drag(nowMs: number): void {
    this.dragging = true;
    if (nowMs - this.askedMs < kDragMs) return;
    this.askedMs = nowMs;
    this.seek(this.place.valueAsNumber);
  }

  private seek(volume: number): void {
    this.ask(Wish.SEEK, volume);
    this.expect(volume);
  }

  /** Shows a volume at once if it was on show before. */
  private expect(volume: number): void {
    if (!this.mayAsk) return; // the server will refuse
    this.expected = volume;
    this.expectedMs = performance.now();
    this.loop.stop();
    this.kept.endLoop();
    this.kept.show(this.loop.of(volume)?.volumeId ?? 0n);
  }

  private ask(wish: Wish, value = 0, volumeId = 0n): void {
    this.send({ requestId: (this.lastId += 1n), wish, value, volumeId });
  }
}

/** Writes only changed text, because a screen reader announces every write. */
function write(place: Element, text: string): void {
  if (place.textContent !== text) place.textContent = text;
}
