// SPDX-License-Identifier: Apache-2.0
// Measures a region of fluid: the server grows it from a point in a plane. Its border is drawn until it is kept, grown
// with another border, or dropped.
import type { FluidReply, Picture } from "../../generated/fanlight_pb.js";
import { find } from "../element";
import type { Figure, Mm } from "./figures";
import { figureText } from "./figures";
import { kNotForDiagnosis, volumeOfPicture, type Measurement, type MeasurementList } from "./measurement_list";
import { regionGrid, type RegionGrid } from "./region_border";

const kStepDb = 1.5; // of the border's level, as the deviation is for
const kLeastDb = -6;
const kMostDb = 3; // the server's: above, the border is about as bright as the wall
const kMm3PerCm3 = 1000;
const kUncertain = 0.15; // of the volume: a border that moves this much by kStepDb may be none
const kKeep = "The line follows the border: keep the volume";
const kUnseen = "No plane on show passes through the border: show the planes (key 4)";

/** FluidRequest */
export interface FluidQuestion {
  requestId: bigint;
  volumeId: bigint;
  xMm: number;
  yMm: number;
  zMm: number;
  borderDb: number;
}

export interface FluidEvents {
  ask(question: FluidQuestion): void;
  say(sentence: string): void;
  captured(picture: Picture): Date | undefined;
  /** What is drawn has changed. */
  changed(): void;
  /** The border was removed: what can be done now is to be said. */
  dropped(): void;
}

interface Seed {
  picture: Picture;
  at: Mm;
  place: string;
  borderDb: number;
}

/** What was found and is not kept yet. */
interface Offer extends Seed {
  grid: RegionGrid;
  volume: Figure;
}

export class FluidProbe {
  private asked: (Seed & { id: bigint }) | undefined;
  private offer: Offer | undefined;
  private lastId = 0n;
  private readonly bar = find("#fluid-bar", HTMLElement);
  private readonly keepButton = find("#keep-fluid", HTMLButtonElement);
  private readonly tighter = find("#fluid-tighter", HTMLButtonElement);
  private readonly wider = find("#fluid-wider", HTMLButtonElement);

  constructor(
    private readonly list: MeasurementList,
    private readonly events: FluidEvents,
  ) {
    this.keepButton.onclick = () => this.keep();
    find("#drop-fluid", HTMLButtonElement).onclick = () => {
      this.drop();
      this.events.dropped();
    };
    this.tighter.onclick = () => this.growAgain(-kStepDb);
    this.wider.onclick = () => this.growAgain(kStepDb);
  }

  get isAsking(): boolean {
    return this.asked !== undefined;
  }

  /** The border that is shown and not kept. */
  get shown(): RegionGrid | undefined {
    return this.offer?.grid;
  }

  /** Whether the picture shows the border: what is not seen cannot be accepted. */
  setSeen(isSeen: boolean): void {
    this.keepButton.disabled = !isSeen || this.isAsking;
    this.keepButton.title = isSeen ? kKeep : kUnseen;
  }

  /** `place`: such as "in plane A". */
  begin(picture: Picture, at: Mm, place: string): void {
    this.offer = undefined;
    this.ask({ picture, at, place, borderDb: 0 });
  }

  /** Forgets what is under way. */
  drop(): void {
    this.asked = this.offer = undefined;
    this.refresh();
  }

  answered({ requestId, outcome }: FluidReply): void {
    const asked = this.asked;
    if (!asked || requestId !== asked.id) return;
    this.asked = undefined;
    if (outcome.case === "refused") {
      const before = this.offer ? ` The border before is still drawn: ${offerText(this.offer)}.` : "";
      this.events.say(`No volume: ${outcome.value.message}.${before}`);
      return this.refresh();
    }
    const grid = outcome.case === "found" ? regionGrid(outcome.value) : undefined;
    if (outcome.case !== "found" || !grid) {
      this.events.say("The server's answer cannot be read.");
      return this.refresh();
    }
    const cm3 = (mm3: number) => mm3 / kMm3PerCm3;
    const { volumeMm3, deviationMm3 } = outcome.value;
    const volume = { name: "volume", value: cm3(volumeMm3), unit: "cm³", uncertainty: cm3(deviationMm3) } as const;
    this.offer = { ...asked, grid, volume };
    const warning = deviationMm3 > kUncertain * volumeMm3 ? "Uncertain: the line may run into tissue. " : "";
    this.events.say(
      `${offerText(this.offer)}. ${warning}Keep it if the line follows the border in every plane. ${kNotForDiagnosis}`,
    );
    this.refresh();
  }

  private ask(seed: Seed): void {
    const { picture, at, borderDb } = seed;
    this.asked = { ...seed, id: (this.lastId += 1n) };
    this.events.say("Looking for the border…");
    const [xMm, yMm, zMm] = at;
    this.events.ask({ requestId: this.lastId, volumeId: picture.volumeId, xMm, yMm, zMm, borderDb });
    this.refresh();
  }

  private growAgain(byDb: number): void {
    if (this.offer && !this.asked) this.ask({ ...this.offer, borderDb: this.offer.borderDb + byDb });
  }

  private keep(): void {
    const { offer } = this;
    if (!offer || this.asked) return;
    const captured = this.events.captured(offer.picture);
    const made: Measurement | undefined = this.list.addFluid(
      {
        place: `clicked ${offer.place}${shiftText(offer.borderDb)}`,
        points: [offer.at],
        region: offer.grid,
        of: volumeOfPicture(offer.picture),
        ...(captured && { captured }),
      },
      offer.volume,
    );
    if (made) {
      this.offer = undefined;
      this.events.say(`Kept as measurement ${made.name}. ${kNotForDiagnosis}`);
    } else {
      this.events.say("There are many measurements already: remove some first.");
    }
    this.refresh();
  }

  private refresh(): void {
    // Not after a click, which leaves the keys to the page.
    const had = this.bar.querySelector(":focus-visible") !== null;
    this.bar.hidden = this.offer === undefined;
    if (had && this.bar.hidden) find("#measure-kind", HTMLSelectElement).focus(); // not lost with the buttons
    const atDb = this.offer?.borderDb ?? 0;
    this.tighter.disabled = this.isAsking || atDb <= kLeastDb;
    this.wider.disabled = this.isAsking || atDb >= kMostDb;
    this.events.changed();
  }
}

function offerText({ volume, borderDb }: Offer): string {
  return `${figureText(volume)}${shiftText(borderDb)}`;
}

function shiftText(borderDb: number): string {
  return borderDb === 0 ? "" : `, border ${Math.abs(borderDb)} dB ${borderDb > 0 ? "wider" : "tighter"}`;
}
