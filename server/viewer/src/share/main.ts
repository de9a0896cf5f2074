// SPDX-License-Identifier: Apache-2.0
// A file with surfaces that needs no server: light, turn, film and measurement, by the code of the page.
import { fromBinary } from "@bufbuild/protobuf";
import { SharedSurfacesSchema, type SharedSurfaces } from "../../generated/fanlight_pb.js";
import { find } from "../element";
import { LightHandles } from "../light_handles";
import { Orbit } from "../orbit";
import { PictureInput } from "../picture_input";
import { valuesOf } from "../scene";
import { SettingsEditor } from "../settings_editor";
import { SurfaceView } from "../surface/surface_view";
import type { Tool } from "../tools";
import { Film } from "./film";
import { Ruler } from "./ruler";
import { SurfaceStage } from "./surface_stage";

const canvas = find("#picture", HTMLCanvasElement);
const said = find("#said", HTMLElement);

function say(sentence: string): void {
  said.textContent = sentence;
  said.hidden = sentence === "";
}

function bytesOf(base64: string): Uint8Array {
  return Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
}

function show(surfaces: SharedSurfaces): void {
  const defaults = surfaces.scene ? valuesOf(surfaces.scene) : new Map();
  const editor: SettingsEditor = new SettingsEditor({
    send: (requestId) => queueMicrotask(() => editor.keptHere(requestId)), // there is no server
    changed: () => stage?.changed(),
    refused: say,
    accepted: () => undefined,
  });
  const view = new SurfaceView(editor);
  if (!view.works) return say("This browser has no WebGL 2, which is needed to show the surface.");
  const stage = new SurfaceStage(canvas, view, editor);
  editor.start(surfaces.fields, 1n, defaults);
  const orbit = new Orbit(editor, canvas, () => true);
  orbit.start(surfaces.fields, defaults);
  const light = new LightHandles(editor, canvas, new Map(), () => true);
  const ruler = new Ruler(canvas, find("#measurement", SVGSVGElement), view, say);
  const tool = () => (document.querySelector<HTMLInputElement>("#tools input:checked")?.value ?? "orbit") as Tool;
  find("#tools", HTMLElement).onchange = () => ruler.choose(tool() === "measure");
  find("#reset", HTMLButtonElement).onclick = () => orbit.reset();
  new PictureInput(
    canvas,
    find("#frame", HTMLElement),
    tool,
    light,
    orbit,
    (pointer) => tool() === "measure" && ruler.clicked(pointer),
    () => orbit.reset(),
  );
  const failed = (error: Error) => say(`The surface could not be read: ${error.message}`);
  new Film(surfaces.pictures, stage, () => ruler.forget(), failed).start();
}

const data = document.querySelector("#surfaces")?.textContent;
if (data) {
  const surfaces = fromBinary(SharedSurfacesSchema, bytesOf(data));
  document.title = surfaces.title || "Fanlight";
  document.querySelector("h1")!.textContent = surfaces.title;
  find("#made-by", HTMLElement).textContent = surfaces.madeBy;
  show(surfaces);
} else {
  say("There is no surface in this file.");
}
