import { i18n } from "@lingui/core";
import { compileMessage } from "@lingui/message-utils/compileMessage";
import { useLingui } from "@lingui/react";
import { createContext, useCallback, useContext } from "react";

import { nameOf } from "../show/length";
import { UnitContext } from "../show/lengths";
import { de } from "./de";
import { en, type Key } from "./en";

export type { Key };
export type Values = Record<string, string | number>;
export const LANGUAGES = ["en", "de"] as const;

i18n.setMessagesCompiler(compileMessage);
i18n.load({ en, de });

/** Shows all words in a language; an unknown one is English. */
export function speak(language: string): void {
  const known = language === "de" ? "de" : "en";
  i18n.activate(known);
  document.documentElement.lang = known;
}

/** The words of a text by its key; `{um}` and `{mm}` in it are the units that the reader's lengths are shown in. */
export function useText() {
  const { i18n: words } = useLingui();
  const unit = useContext(UnitContext);
  return useCallback(
    (key: Key, values?: Values) => words._(key, { um: nameOf(unit, "um"), mm: nameOf(unit, "mm"), ...values }),
    [words, words.locale, unit],
  );
}

/** The words for a name that the service uses; the name itself where there are none. */
export function useName() {
  const text = useText();
  return (kind: string, name: string | null | undefined) => {
    const key = `${kind}.${name}`;
    return !name ? "" : key in en ? text(key as Key) : name;
  };
}

/** The controls whose programs are read, by the names that the service uses. */
export const DIALECTS = Object.keys(en).flatMap((key) => (key.startsWith("dialect.") ? [key.slice("dialect.".length)] : []));

/** Whether a page states by its fields what a job file states elsewhere. */
export const ByFields = createContext(false);

/** What to do about a refusal: on a page of fields in its words, not in those of files and commands. */
export function useHint() {
  const word = useName();
  const own = useContext(ByFields);
  return ({ code, hint }: { code: string; hint: string }) => (own && `hint.${code}` in en ? word("hint", code) : hint);
}
