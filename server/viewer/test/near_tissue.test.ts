// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";
import { test } from "node:test";
import { NearTissue } from "../generated/fanlight_pb.js";
import { nearTissueText } from "../src/near_tissue";

test("the mark says what a picture shows of the near tissue", () => {
  assert.equal(nearTissueText(NearTissue.SHOWN), "");
  assert.equal(nearTissueText(NearTissue.REMOVED), "Near tissue removed");
  assert.match(nearTissueText(NearTissue.NOT_FOUND), /nothing removed/);
  assert.equal(nearTissueText(NearTissue.REMOVED_TO_BONE), "Removed up to the bone");
  assert.match(nearTissueText(NearTissue.NO_BONE), /nothing removed/);
});
