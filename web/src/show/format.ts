import { i18n } from "@lingui/core";

const NONE = "–";

/** Of numbers and times: English with a day of 24 hours. */
function locale(): string {
  return i18n.locale === "de" ? "de-DE" : "en-GB";
}

/** A number in the reader's way of writing; an unknown one is a dash. */
export function number(value: number | null | undefined, digits = 1): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return NONE;
  const form = { minimumFractionDigits: digits, maximumFractionDigits: digits };
  return new Intl.NumberFormat(locale(), form).format(value).replace("-", "−");
}

/** With its sign, for deviations and changes. */
export function signed(value: number | null | undefined, digits = 1): string {
  const shown = number(value, digits);
  return shown === NONE || shown.startsWith("−") || !/[1-9]/.test(shown) ? shown : `+${shown}`;
}

const DAY_MS = 86_400_000;

/** A clock time of the last day, else with its date. */
export function moment(at: string | number | null | undefined): string {
  if (at === null || at === undefined || at === "") return NONE;
  const time = new Date(at);
  if (Number.isNaN(time.getTime())) return String(at);
  const near = Math.abs(Date.now() - time.getTime()) < DAY_MS;
  const form: Intl.DateTimeFormatOptions = near ? { timeStyle: "medium" } : { dateStyle: "medium", timeStyle: "short" };
  return new Intl.DateTimeFormat(locale(), form).format(time);
}

/** How long ago, in its largest unit. */
export function ago(ms: number): string {
  const s = Math.max(0, Math.round(ms / 1000));
  const [value, unit] = s < 60 ? [s, "second"] : s < 3600 ? [s / 60, "minute"] : s < 86_400 ? [s / 3600, "hour"] : [s / 86_400, "day"];
  return new Intl.NumberFormat(locale(), { style: "unit", unit, maximumFractionDigits: 0 }).format(Math.floor(value));
}

/** Enough of a hash to tell it from others. */
export function hash(sha256: string): string {
  return sha256.slice(0, 12);
}
