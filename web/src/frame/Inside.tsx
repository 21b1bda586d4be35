import { Loader } from "@mantine/core";
import { useEffect } from "react";
import { useLocation } from "wouter";

import { client, nowIs, useMe } from "../api/asking";
import { useContactKept } from "../live/contact";
import { listen } from "../live/news";
import { UnitContext } from "../show/lengths";
import { MeContext } from "../show/roles";
import { Refused } from "../show/parts";
import { speak, useText } from "../text/text";
import { Pages } from "./Pages";
import { Shell } from "./Shell";
import { SignIn } from "./SignIn";

/** Signing in, or the pages for who is signed in. */
export function Inside() {
  const me = useMe();
  const text = useText();
  const [place] = useLocation();
  useContactKept();
  useSessionWatched();
  const name = me.data?.name;
  const language = me.data?.language;
  useEffect(() => {
    if (language) speak(language);
  }, [language]);
  useEffect(() => (name ? listen() : undefined), [name]);

  if (me.data === undefined) return me.error ? <Refused problem={me.error} /> : <Loader aria-label={text("loading")} />;
  if (me.data === null) return <SignIn />;
  return (
    <MeContext value={me.data}>
      <UnitContext value={me.data.unit}>
        {place === "/wall" ? (
          <Pages />
        ) : (
          <Shell>
            <Pages />
          </Shell>
        )}
      </UnitContext>
    </MeContext>
  );
}

/** A session that has ended shows where to sign in again. */
function useSessionWatched(): void {
  useEffect(
    () =>
      client.getQueryCache().subscribe(({ query }) => {
        const error = query.state.error as { status?: number } | null;
        if (error?.status === 401 && client.getQueryData(["me"])) nowIs(null);
      }),
    [],
  );
}
