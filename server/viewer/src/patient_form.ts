// SPDX-License-Identifier: Apache-2.0
// The patient of the stills that go to the archive: typed in, or of an order that `fanlight worklist --save` has
// written. Kept until the page is closed, and nowhere else.
import { element } from "./element";

/** As the server takes it; names as in server/pacs/identity_json.cpp. */
export type Patient = Readonly<Record<string, string>>;

const kMostFileBytes = 65_536;

export class PatientForm {
  readonly root = element("div", { className: "patient" });
  private readonly id = textBox("Patient ID", 64);
  private readonly family = textBox("Family name", 63);
  private readonly given = textBox("Given name", 63);
  private readonly born = textBox("Date of birth", 10);
  private readonly sex = element("select", { ariaLabel: "Sex" });
  private readonly accession = textBox("Accession number", 16);
  private readonly file = element("input", { type: "file", accept: ".json", hidden: true });
  private order: Patient | undefined; // all fields then are its own

  /** `failed`: an order could not be read; an empty sentence where it was, or where all is cleared. */
  constructor(private readonly failed: (sentence: string) => void) {
    const choices = { "": "Not given", F: "Female", M: "Male", O: "Other" };
    for (const [value, text] of Object.entries(choices)) this.sex.append(element("option", { value }, text));
    this.born.type = "date";
    const load = element("button", { type: "button" }, "Load order…");
    load.title = "A file of fanlight worklist --save";
    load.onclick = () => this.file.click();
    const clear = element("button", { type: "button" }, "Other patient");
    clear.onclick = () => {
      this.failed("");
      this.forget();
    };
    this.born.max = new Date().toISOString().slice(0, 10);
    this.file.onchange = () => void this.load();
    const rows = [this.id, this.family, this.given, this.born, this.accession].map((box) =>
      element("label", {}, box.ariaLabel!, box),
    );
    rows.splice(4, 0, element("label", {}, "Sex", this.sex));
    this.root.append(...rows, element("div", { className: "buttons" }, load, clear, this.file));
  }

  /** Undefined, with a message, where there is neither an ID nor a name. */
  patient(): Patient | undefined {
    const missing = !this.order && !this.id.value.trim() && !this.family.value.trim();
    this.id.setCustomValidity(missing ? "Enter a patient ID or a name." : "");
    if (!this.id.reportValidity()) return undefined;
    if (this.order) return this.order;
    // These characters separate the parts of names.
    const plain = (box: HTMLInputElement) => box.value.replace(/[\^=]/g, " ").trim();
    const name = [plain(this.family), plain(this.given)].join("^").replace(/\^$/, "");
    const typed = {
      patient_id: this.id.value.trim(),
      patient_name: name,
      birth_date: this.born.value.replaceAll("-", ""),
      sex: this.sex.value,
      accession_number: this.accession.value.trim(),
    };
    return Object.fromEntries(Object.entries(typed).filter(([, value]) => value !== ""));
  }

  forget(): void {
    this.fill(undefined);
  }

  private async load(): Promise<void> {
    const file = this.file.files?.[0];
    if (!file) return;
    try {
      if (file.size > kMostFileBytes) throw new Error("it is too large");
      const json = parsed(await file.text());
      const isOrder = typeof json === "object" && json !== null && ("patient_id" in json || "patient_name" in json);
      if (!isOrder) throw new Error("it names no patient");
      if (Object.values(json).some((value) => typeof value !== "string")) throw new Error("a field is no text");
      this.fill(json as Patient);
      this.failed("");
    } catch (error) {
      this.forget(); // whose data it was is not known
      this.failed(`The file is not an order: ${(error as Error).message}.`);
    }
    this.file.value = ""; // the same file may be chosen again
  }

  /** Shows an order, whose fields belong together; without one, all fields are empty and can be typed in. */
  private fill(order: Patient | undefined): void {
    this.order = order;
    const [family, given] = (order?.["patient_name"] ?? "").split("^");
    this.id.value = order?.["patient_id"] ?? "";
    [this.family.value, this.given.value] = [family ?? "", given ?? ""];
    this.born.value = (order?.["birth_date"] ?? "").replace(/^(....)(..)(..)$/, "$1-$2-$3");
    this.sex.value = order?.["sex"] ?? "";
    this.accession.value = order?.["accession_number"] ?? "";
    const isFixed = order !== undefined;
    for (const box of [this.id, this.family, this.given, this.born, this.accession]) box.readOnly = isFixed;
    this.sex.disabled = isFixed;
  }
}

/** Undefined where it is no JSON. */
function parsed(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}

function textBox(name: string, maxLength: number): HTMLInputElement {
  const box = element("input", { type: "text", maxLength, autocomplete: "off", ariaLabel: name });
  box.oninput = () => box.setCustomValidity("");
  return box;
}
