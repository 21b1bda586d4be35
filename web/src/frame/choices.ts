import { client } from "../api/asking";
import { ask, type Shape } from "../api/client";
import type { LengthUnit } from "../show/length";
import { useUser } from "../show/roles";
import { speak } from "../text/text";

/** Shows all in a language from now on, here and wherever the same person signs in. */
export function useLanguageSet() {
  const set = useMineSet();
  return (language: Shape<"Me">["language"]) => {
    speak(language);
    return set({ language });
  };
}

/** Shows all lengths in a unit from now on, here and wherever the same person signs in. */
export function useUnitSet() {
  const set = useMineSet();
  return (unit: LengthUnit) => set({ unit });
}

function useMineSet() {
  const me = useUser();
  return async (mine: { language: string } | { unit: LengthUnit }) => {
    client.setQueryData(["me"], { ...me, ...mine });
    await ask("PATCH", "me", { body: mine }).catch(() => undefined);
  };
}
