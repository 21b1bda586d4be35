import { nameOf, shownIn, type Given, type LengthUnit } from "../length";

/** Colours by what they mean: variables of look.css. */
export type Colour = "after" | "left-on" | "taken" | "soft" | "bad" | "busy" | "good" | "line" | "warm";

/** Values over the same places; `dots` alone where `line` is false. */
export interface Line {
  name: string;
  colour: Colour;
  values: (number | null)[];
  line?: boolean;
  dots?: "full" | "open";
  dash?: boolean;
  /** Joined over places that have no value. */
  joined?: boolean;
  /** Half the width of a band about it. */
  band?: (number | null)[];
}

/** What does not stand at the places of the lines. */
export interface Mark {
  x: number;
  y: number;
  colour: Colour;
  shape: "full" | "open" | "alarm";
}

/** One picture: lines over `x`, limits as `levels`, what happened at a place as `uprights`. */
export interface Plot {
  x: number[];
  lines: Line[];
  marks?: Mark[];
  levels?: { at: number; name: string; colour?: Colour }[];
  uprights?: { at: number; name: string }[];
  /** Between them nothing was seen: greyed. */
  unseen?: [number, number][];
  /** Where something was wrong: in red. */
  shaded?: [number, number][];
  xName: string;
  yName: string;
  /** What the values are lengths of: the picture is then in the reader's unit, which its axis names. */
  yIn?: Given;
  xText?: (at: number) => string;
  /** Places that a tick of x may stand at: whole numbers of parts, or of an angle. */
  whole?: boolean;
  /** Places are times, s since 1970. */
  time?: boolean;
}

/** The same picture in a reader's unit. */
export function inUnit(plot: Plot, unit: LengthUnit): Plot {
  const { yIn, lines, marks = [], levels = [] } = plot;
  if (!yIn) return plot;
  const to = (value: number) => shownIn(unit, yIn, value);
  const each = (values: (number | null)[]) => values.map((value) => (value === null ? null : to(value)));
  return {
    ...plot,
    lines: lines.map((one) => ({ ...one, values: each(one.values), ...(one.band ? { band: each(one.band) } : {}) })),
    marks: marks.map((one) => ({ ...one, y: to(one.y) })),
    levels: levels.map((one) => ({ ...one, at: to(one.at) })),
    yName: `${plot.yName} ${nameOf(unit, yIn)}`.trim(),
  };
}

/** From the least to the largest of all that is shown, with air. */
export function heightOf({ lines, marks = [], levels = [] }: Plot): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  const take = (value: number | null | undefined) => {
    if (value === null || value === undefined || !Number.isFinite(value)) return;
    low = Math.min(low, value);
    high = Math.max(high, value);
  };
  for (const { values, band } of lines) {
    values.forEach((value, k) => {
      const half = band?.[k] ?? 0;
      if (value !== null) [value - half, value + half].forEach(take);
    });
  }
  marks.forEach(({ y }) => take(y));
  levels.forEach(({ at }) => take(at));
  if (low > high) return [-1, 1];
  const air = 0.08 * (high - low) || Math.abs(high) * 0.1 || 1;
  return [low - air, high + air];
}
