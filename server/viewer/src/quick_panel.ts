// SPDX-License-Identifier: Apache-2.0
// The settings in reach: presets, panes, six sliders, views, the search among the others; undo and redo.
import { Role, type Hello, type Picture, type PresetList } from "../generated/fanlight_pb.js";
import { find } from "./element";
import { sameCuts } from "./cut_shapes";
import type { FieldEffects } from "./field_effects";
import { UncertainMark } from "./uncertain_mark";
import { NearTissueButton } from "./near_tissue";
import { OwnPresets, type OwnPresetEvents } from "./own_presets";
import { LampPanel } from "./lamp_panel";
import type { LightHandles } from "./light_handles";
import { page } from "./page";
import { connectViews, LayoutBar, PresetBar } from "./preset_bar";
import { QuickSettings } from "./quick_settings";
import { ResetPlanes } from "./reset_planes";
import type { Values } from "./scene";
import { connectSearch } from "./setting_search";
import type { SettingsEditor } from "./settings_editor";
import { SlabControl } from "./slab_control";
import { SteadyMark } from "./steady_mark";
import { Tomography } from "./tomography";
import { followHand } from "./hand_gesture";
import { UndoHistory } from "./undo_history";
import { picturePixel, surfacePart, type PagePoint } from "./view_geometry";

export class QuickPanel {
  private readonly history = new UndoHistory();
  private readonly sliders: QuickSettings;
  private readonly presets: PresetBar;
  private readonly ownPresets: OwnPresets;
  private readonly layout: LayoutBar;
  private readonly uncertain = new UncertainMark(find("#uncertain-mark", HTMLElement));
  private readonly steady = new SteadyMark(find("#steady-mark", HTMLElement));
  private readonly nearTissue: NearTissueButton;
  private readonly slab: SlabControl;
  private readonly tomography: Tomography;
  private readonly resetPlanes: ResetPlanes;
  private readonly lamps: LampPanel;
  private allowed = false;
  private readonly failed: (sentence: string) => void;

  constructor(
    private readonly editor: SettingsEditor,
    effects: FieldEffects,
    light: LightHandles,
    presetEvents: OwnPresetEvents,
  ) {
    this.failed = presetEvents.failed;
    this.ownPresets = new OwnPresets(page.ownPresets, editor, presetEvents);
    this.sliders = new QuickSettings(page.quick, editor, effects);
    this.presets = new PresetBar(page.presets, editor, presetEvents.found);
    this.layout = new LayoutBar(page.layout, editor);
    this.nearTissue = new NearTissueButton(page.nearTissue, find("#near-tissue-mark", HTMLElement), editor);
    this.slab = new SlabControl(editor);
    this.tomography = new Tomography(editor);
    this.resetPlanes = new ResetPlanes(editor);
    connectViews(page.views, editor);
    this.lamps = new LampPanel(editor, light, page.lights);
    connectSearch(page.findSetting, page.form, find("#no-setting", HTMLElement));
    page.undo.onclick = () => this.undo();
    page.redo.onclick = () => this.redo();
    followHand(this.history);
  }

  /** Call at the start of a session. */
  start({ presets, role }: Hello): void {
    this.presets.start(presets);
    this.ownPresets.allow(role !== Role.VIEWER);
  }

  /** The presets that people have saved. */
  takePresets(list: PresetList): void {
    this.presets.show(this.ownPresets.tell(list));
  }

  /** Sets what the search for the surface found. */
  setFound(found: Values): void {
    this.presets.setFound(found);
  }

  /** What was changed in another view cannot be taken back in this one. */
  forgetChanges(): void {
    this.history.clear();
    this.refresh();
  }

  /** The server has refused the last change. */
  refused(): void {
    this.history.drop();
    this.refresh();
  }

  /** The scene has changed. */
  refresh(): void {
    this.sliders.refresh();
    this.presets.refresh();
    this.layout.refresh();
    this.nearTissue.refresh();
    this.slab.refresh();
    this.tomography.refresh();
    this.resetPlanes.refresh();
    this.lamps.refresh();
    page.undo.disabled = !this.allowed || !this.history.canUndo;
    page.redo.disabled = !this.allowed || !this.history.canRedo;
  }

  /** The picture shown. */
  take(picture: Picture): void {
    this.sliders.take(picture.levels);
    this.nearTissue.showPicture(picture.nearTissue);
    this.uncertain.show(picture);
    this.steady.show(picture);
  }

  /** Whether the picture lacks a change of this display. */
  setBusy(busy: boolean): void {
    this.sliders.setBusy(busy);
  }

  /** Whether this display may change settings. In a view of its own a preset or the panes cannot change. */
  allow(may: boolean, ownView: boolean): void {
    const changed = this.allowed !== may;
    this.allowed = may;
    for (const part of [page.quick, page.views, page.lights, page.lamps]) part.inert = !may;
    for (const part of [page.presets, page.layout]) part.inert = !may || ownView;
    page.nearTissue.disabled = !may || ownView;
    this.slab.allow(may && !ownView);
    this.tomography.allow(may && !ownView);
    this.resetPlanes.allow(may && !ownView);
    if (changed) this.refresh();
  }

  edited(before: Values, after: Values, gesture?: object): void {
    this.history.add(before, after, performance.now(), gesture);
  }

  undo(): void {
    const cuts = this.history.last?.get("cuts.shapes");
    if (this.allowed && cuts !== undefined && !sameCuts(String(cuts), this.editor.text("cuts.shapes"))) {
      // The text holds the cuts of all displays: to put the one before back would take theirs too.
      this.history.drop();
      this.refresh();
      return this.failed("Another display has cut since: your last cut cannot be undone alone.");
    }
    const values = this.allowed ? this.history.undo() : undefined;
    if (values) this.editor.restore(values);
  }

  redo(): void {
    const values = this.allowed ? this.history.redo() : undefined;
    if (values) this.editor.restore(values);
  }

  choosePanes(mode: string): void {
    if (!page.layout.inert) this.layout.choose(mode);
  }

  /** A double click on the 3D pane of four shows it alone. */
  enlarges(pointer: PagePoint, canvas: HTMLCanvasElement): boolean {
    const mode = this.editor.choice("mode");
    const { x, y } = picturePixel(pointer, canvas);
    const part = surfacePart(mode, canvas);
    if (mode !== "slices" || !part || x < part.left || y < part.top) return false;
    this.choosePanes("surface");
    return true;
  }
}
