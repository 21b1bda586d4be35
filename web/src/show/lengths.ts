import { createContext, useContext, useMemo } from "react";

import { number, signed } from "./format";
import { decimalsIn, isLength, namedIn, nameOf, shownIn, type LengthUnit } from "./length";

type Value = number | null | undefined;

/** Lengths as the reader wants them. `unit` is what a value is given in: "mm", "um", or what is no length ("deg"). */
export interface Lengths {
  unit: LengthUnit;
  /** What the unit is called that such values are shown in. */
  name: (unit: string) => string;
  /** A value without its unit, for where that stands beside it or at the head of its column. */
  plain: (unit: string, value: Value, decimals?: number) => string;
  /** The same with its sign. */
  signed: (unit: string, value: Value, decimals?: number) => string;
  /** Name and text of a value that is kept under a name with its unit. */
  named: (name: string, value: string | number) => [string, string];
}

/** The unit that who is signed in has chosen. */
export const UnitContext = createContext<LengthUnit>("mm");

/** Every length that a page shows goes through this: number and unit come of one choice. */
export function useLengths(): Lengths {
  const unit = useContext(UnitContext);
  return useMemo(() => lengthsIn(unit), [unit]);
}

function lengthsIn(unit: LengthUnit): Lengths {
  const by = (form: typeof number) => (of: string, value: Value, decimals?: number) => {
    const digits = decimals ?? (of === "um" ? 1 : 4);
    if (!isLength(of) || value === null || value === undefined) return form(value, digits);
    return form(shownIn(unit, of, value), decimalsIn(unit, of, digits));
  };
  return {
    unit,
    name: (of) => (isLength(of) ? nameOf(unit, of) : of),
    plain: by(number),
    signed: by(signed),
    named: (name, value) => namedIn(unit, name, value),
  };
}

/** What an address is told of who reads it, for its sentences and pictures. */
export function useReader(): string {
  const { unit } = useLengths();
  return `language=${document.documentElement.lang}&unit=${unit}`;
}
