import { client } from "../api/asking";
import { ask } from "../api/client";
import { useUser } from "../show/roles";
import { speak } from "../text/text";

/** Shows all in a language from now on, here and wherever the same person signs in. */
export function useLanguageSet() {
  const me = useUser();
  return async (language: string) => {
    client.setQueryData(["me"], { ...me, language });
    speak(language);
    await ask("PATCH", "me", { body: { language } }).catch(() => undefined);
  };
}
