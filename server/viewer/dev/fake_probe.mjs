// SPDX-License-Identifier: Apache-2.0
// A probe that a test can unplug and plug in again. It rounds its settings.
import { ProbeStatus_State } from "../generated/fanlight_pb.js";

const kRows = {
  sweepDeg: { name: "sweep", unit: " deg", minimum: 10, maximum: 85, step: 0.5 },
  framesAVolume: { name: "number of frames a volume", unit: "", minimum: 8, maximum: 140, step: 1 },
  depthMm: { name: "depth", unit: " mm", minimum: 40, maximum: 240, step: 5 },
};

export class FakeProbe {
  plugged = true;
  #timesLost = 0n;
  #settings = { sweepDeg: 70, framesAVolume: 35, depthMm: 160 };
  #mayBeSet;

  constructor(mayBeSet) {
    this.#mayBeSet = mayBeSet;
  }

  plug() {
    this.plugged = true;
  }

  unplug() {
    if (this.plugged) this.#timesLost += 1n;
    this.plugged = false;
  }

  /** The fields of a ProbeStatus. */
  status() {
    return {
      state: this.plugged ? ProbeStatus_State.STREAMING : ProbeStatus_State.LOST,
      timesLost: this.#timesLost,
      model: "Stand-in FL-1",
      serial: "0007",
      firmware: "1.0",
      settings: this.#settings,
      ...Object.fromEntries(Object.entries(kRows).map(([key, { minimum, maximum }]) => [key, { minimum, maximum }])),
      mayBeSet: this.#mayBeSet,
    };
  }

  /** The outcome of a ProbeReply to these ProbeSettings. */
  change(wanted) {
    const refusal = this.#refusalOf(wanted);
    if (refusal) return { case: "refused", value: { message: refusal } };
    for (const [key, { step }] of Object.entries(kRows)) {
      if (wanted[key] !== undefined) this.#settings[key] = Math.round(wanted[key] / step) * step;
    }
    return { case: "inForce", value: this.#settings };
  }

  #refusalOf(wanted) {
    if (!this.#mayBeSet) {
      return "the probe may not be set over the network, expected a server with --probe-control everyone";
    }
    if (!this.plugged) return "the probe is not connected, expected one";
    for (const [key, { name, unit, minimum, maximum }] of Object.entries(kRows)) {
      if (wanted[key] === undefined || (wanted[key] >= minimum && wanted[key] <= maximum)) continue;
      return `the probe's ${name} was to be ${wanted[key]}${unit}, expected ${minimum} to ${maximum}${unit}`;
    }
    return undefined;
  }
}
