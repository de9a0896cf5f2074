// SPDX-License-Identifier: Apache-2.0
// The status line.
import type { Hello, Picture, Statistics } from "../generated/fanlight_pb.js";
import { deadlineText } from "./deadline_text";
import { interpolatedText, mismatchText, sparseText } from "./loss_text";
import { PicturePace } from "./picture_pace";
import { Plot } from "./plots";
import type { ServerClock } from "./server_clock";

const kRefreshMs = 250; // numbers that change faster are unreadable

export class StatisticsView {
  private readonly pace: PicturePace;
  private readonly plots = {
    age: new Plot("Age of the picture", "ms"),
    rate: new Plot("Pictures a second", "/s"),
    stages: new Plot("All stages of a picture", "ms"),
  };
  private stagesMs: number | undefined;

  constructor(
    private readonly page: ParentNode,
    clock: ServerClock,
  ) {
    this.pace = new PicturePace((pageMs) => clock.at(pageMs));
    page.querySelector("#plots")?.append(...Object.values(this.plots).map(({ root }) => root));
    window.setInterval(() => this.refreshPace(), kRefreshMs);
  }

  start(hello: Hello): void {
    this.pace.reset();
    this.write("device", hello.device);
    this.write("server-version", hello.serverVersion);
  }

  picture(picture: Picture): void {
    this.pace.add(performance.now(), Number(picture.captureTimeNs) / 1e6);
    this.write("picture-id", picture.pictureId);
    this.write("volume-id", picture.volumeId);
    this.write("scene-revision", picture.sceneRevision);
    this.write("stream", streamText(picture));
    this.write("pass1-runs", picture.pass1Runs);
    this.write("pass2-runs", picture.pass2Runs);
    this.writeWhereAny("frames-missing", interpolatedText(picture));
    this.writeWhereAny("sparse", sparseText(picture.warnings));
    this.writeWhereAny("deadline", deadlineText(picture));
    this.writeStages(picture);
  }

  counters(statistics: Statistics): void {
    this.write("frames-lost", statistics.framesLost);
    this.write("pictures-skipped", statistics.picturesSkipped);
    this.writeWhereAny("volumes-interpolated", String(statistics.volumesInterpolated || ""));
    this.writeWhereAny("mismatch", mismatchText(statistics));
    this.write("sessions", statistics.sessions);
  }

  private refreshPace(): void {
    const nowMs = performance.now();
    const ageMs = this.pace.ageMs(nowMs);
    this.write("pictures-per-second", this.pace.perSecond(nowMs).toFixed(1));
    this.write("picture-age-ms", ageMs === undefined ? "–" : Math.round(ageMs));
    this.plots.age.add(ageMs);
    this.plots.rate.add(this.pace.perSecond(nowMs));
    this.plots.stages.add(this.stagesMs);
    const isShown = this.find("stages").closest("[hidden]") === null;
    if (isShown) for (const plot of Object.values(this.plots)) plot.draw();
  }

  private writeStages(picture: Picture): void {
    this.stagesMs = picture.stages.reduce((sum, stage) => sum + stage.milliseconds, 0);
    const list = this.find("stages");
    while (list.childElementCount > picture.stages.length) list.lastElementChild?.remove();
    picture.stages.forEach((stage, index) => {
      const item = list.children[index] ?? list.appendChild(stageItem());
      item.children[0]!.textContent = stage.name.replace(/_/g, " ");
      item.children[1]!.textContent = `${stage.milliseconds.toFixed(1)} ms`;
    });
  }

  /** Hides the value and its title while the text is empty. */
  private writeWhereAny(name: string, text: string): void {
    this.write(name, text);
    this.find(name).closest<HTMLElement>("[data-where-any]")!.hidden = text === "";
  }

  private write(name: string, value: string | number | bigint): void {
    const text = String(value);
    const place = this.find(name);
    if (place.textContent !== text) place.textContent = text;
  }

  private find(name: string): Element {
    const place = this.page.querySelector(`[data-stat="${name}"]`);
    if (!place) throw new Error(`The page has no place for ${name}.`);
    return place;
  }
}

function streamText({ surface, h264, png, width, height }: Picture): string {
  const codec = h264.length > 0 ? "H.264" : png.length > 0 ? "PNG" : "JPEG";
  return `${surface ? "surface, lit here" : codec}, ${width} × ${height}`;
}

function stageItem(): HTMLElement {
  const item = document.createElement("div");
  item.append(document.createElement("dt"), document.createElement("dd"));
  return item;
}
