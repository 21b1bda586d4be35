/** The unit of lengths that a reader has chosen. What the service says and takes is in mm and µm whatever it is. */
export type LengthUnit = "mm" | "inch";
/** What a length is given in: sizes in mm, errors in µm. */
export type Given = "mm" | "um";

const MM_PER_INCH = 25.4;
/** Of an inch in mm, of a microinch in µm. */
const PER_UNIT: Record<Given, number> = { mm: MM_PER_INCH, um: MM_PER_INCH / 1000 };
const NAMES: Record<LengthUnit, Record<Given, string>> = { mm: { mm: "mm", um: "µm" }, inch: { mm: "in", um: "µin" } };
/** Decimals that a value kept as text may have had: its zeros are not written. */
const KEPT: Record<Given, number> = { mm: 3, um: 1 };

/** Whether numbers of a unit are lengths that a reader's choice is for; degrees and shares are none. */
export function isLength(unit: string): unit is Given {
  return unit === "mm" || unit === "um";
}

/** What the unit is called that lengths given so are shown in: inches for mm, microinches for µm. */
export function nameOf(unit: LengthUnit, given: Given): string {
  return NAMES[unit][given];
}

/** A length in the unit that `nameOf` names. */
export function shownIn(unit: LengthUnit, given: Given, value: number): number {
  return unit === "mm" ? value : value / PER_UNIT[given];
}

/** A length that was typed in the unit that `nameOf` names, in mm or µm. */
export function keptFrom(unit: LengthUnit, given: Given, value: number): number {
  return unit === "mm" ? value : value * PER_UNIT[given];
}

/** A number as it is typed, with a point or a comma; null for an empty field, NaN for text that is no number. */
export function typed(text: string): number | null {
  const plain = text.trim().replace(",", ".").replace("−", "-");
  if (plain === "") return null;
  return /^[+-]?(\d+\.?\d*|\.\d+)$/.test(plain) ? Number(plain) : NaN;
}

/** A length as it was typed, with the unit that its field had then. */
export interface TypedLength {
  text: string;
  unit: LengthUnit;
}
export const EMPTY_LENGTH: TypedLength = { text: "", unit: "mm" };
const SHOWN_DIGITS = 7;

/** A typed length in mm or µm, whatever unit the reader has chosen since; null for an empty field, NaN for no number. */
export function keptOf(given: Given, length: TypedLength): number | null {
  const value = typed(length.text);
  return value === null ? null : keptFrom(length.unit, given, value);
}

/** The text of the field of a typed length: as it was typed, or converted to the unit that the field has now. */
export function textIn(unit: LengthUnit, given: Given, length: TypedLength): string {
  const kept = keptOf(given, length);
  if (unit === length.unit || kept === null || Number.isNaN(kept)) return length.text;
  const shown = String(Number(shownIn(unit, given, kept).toPrecision(SHOWN_DIGITS)));
  return length.text.includes(",") ? shown.replace(".", ",") : shown;
}

/** The fewest decimals that still tell apart what so many decimals of the given unit do. */
export function decimalsIn(unit: LengthUnit, given: Given, decimals: number): number {
  return Math.max(0, Math.ceil(decimals - Math.log10(shownIn(unit, given, 1))));
}

/** A value that is kept under a name with its unit ("radius_mm"), name and text in the reader's; others as they are. */
export function namedIn(unit: LengthUnit, name: string, value: string | number): [string, string] {
  const given = /_(mm|um)$/.exec(name)?.[1] as Given | undefined;
  const text = String(value);
  if (unit === "mm" || !given || !/^[+-]?\d+(\.\d+)?$/.test(text)) return [name, text];
  const decimals = Math.max(text.split(".")[1]?.length ?? 0, KEPT[given]);
  const shown = shownIn(unit, given, Number(text)).toFixed(decimalsIn(unit, given, decimals));
  return [`${name.slice(0, -given.length)}${given === "mm" ? "in" : "uin"}`, shown];
}
