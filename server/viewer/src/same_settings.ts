// SPDX-License-Identifier: Apache-2.0
import { create, equals } from "@bufbuild/protobuf";
import { HelloSchema, type Hello } from "../generated/fanlight_pb.js";

/** Whether two sessions offer the same settings with the same defaults. */
export function sameSettings(a: Hello, b: Hello): boolean {
  const settings = ({ fields, defaultScene }: Hello) =>
    create(HelloSchema, { fields, ...(defaultScene && { defaultScene }) });
  return equals(HelloSchema, settings(a), settings(b));
}
