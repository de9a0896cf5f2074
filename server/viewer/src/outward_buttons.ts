// SPDX-License-Identifier: Apache-2.0
// The buttons by which pictures and volumes leave this server: as a file, or to an archive.
import { ArchiveButton, type ArchiveEvents } from "./archive_button";
import { bannerAt } from "./banner";
import { page } from "./page";
import { ShareButton } from "./share_button";

export class OutwardButtons {
  private readonly share: ShareButton;
  private readonly archive: ArchiveButton;

  constructor(
    overlay: Pick<ArchiveEvents, "loss"> & {
      stillBlob: ArchiveEvents["still"];
      stillCanvas: ArchiveEvents["frame"];
      volumeId(): bigint | undefined;
    },
    cine: { isStill: boolean; isHeld: boolean; isBehind: boolean },
    failed: (sentence: string) => void,
  ) {
    this.share = new ShareButton(page.share, failed);
    this.archive = new ArchiveButton(page.archive, {
      still: () => overlay.stillBlob(),
      frame: () => overlay.stillCanvas(),
      loss: () => overlay.loss(),
      frozenVolume: () => (cine.isStill && !cine.isHeld && !cine.isBehind ? overlay.volumeId() : undefined),
      sent: bannerAt("#archived"),
      failed,
    });
  }

  /** Whether this display's role may do it. */
  allow(may: boolean): void {
    this.share.allow(may);
    this.archive.allow(may);
  }
}
