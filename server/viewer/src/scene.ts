// SPDX-License-Identifier: Apache-2.0
// A scene as a map from dotted names, those of Hello.fields, to values.
import { create } from "@bufbuild/protobuf";
import { reflect, type ReflectMessage } from "@bufbuild/protobuf/reflect";
import { SceneSchema, type Scene, type SceneField } from "../generated/fanlight_pb.js";

/** A number, the index of a choice, or a text (SceneField.is_text). */
export type Value = number | string;
export type Values = Map<string, Value>;

export function valuesOf(scene: Scene): Values {
  const values: Values = new Map();
  collect(reflect(SceneSchema, scene), "", values);
  return values;
}

/** The message with these fields only. Names that the schema does not have are left out. */
export function sceneOf(values: Values): Scene {
  const scene = create(SceneSchema);
  for (const [name, value] of values) place(reflect(SceneSchema, scene), name.split("."), value);
  return scene;
}

/** NaN if it is not a number. */
export function numberOf(value: Value | undefined): number {
  return typeof value === "number" ? value : NaN;
}

/** Empty if it is not a text. */
export function textOf(value: Value | undefined): string {
  return typeof value === "string" ? value : "";
}

/** The nearest allowed value of the field. */
export function allowed(field: SceneField, value: number): number {
  const stepped =
    field.step > 0 ? field.minimum + Math.round((value - field.minimum) / field.step) * field.step : value;
  return Math.min(field.maximum, Math.max(field.minimum, stepped));
}

function collect(message: ReflectMessage, prefix: string, values: Values): void {
  for (const field of message.fields) {
    if (!message.isSet(field)) continue;
    if (field.fieldKind === "message") {
      collect(message.get(field), `${prefix}${field.name}.`, values);
    } else {
      const value: unknown = message.get(field);
      values.set(prefix + field.name, typeof value === "string" ? value : Number(value));
    }
  }
}

function place(message: ReflectMessage, path: string[], value: Value): void {
  const field = message.fields.find((candidate) => candidate.name === path[0]);
  if (field?.fieldKind === "message") {
    const part = message.get(field);
    place(part, path.slice(1), value);
    message.set(field, part);
  } else if (field) {
    message.set(field, value);
  }
}
