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
