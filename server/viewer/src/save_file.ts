// SPDX-License-Identifier: Apache-2.0
// Gives a file to the browser to save.

export function saveFile(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** "2026-11-23-08-30-00" */
export function timeInName(): string {
  return new Date().toISOString().slice(0, 19).replace(/[:T]/g, "-");
}
