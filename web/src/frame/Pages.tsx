import { Loader } from "@mantine/core";
import { Suspense, useEffect } from "react";
import { Route, Switch, useLocation } from "wouter";

import { useText } from "../text/text";
import { Fault } from "./Fault";
import { leadsTo, ROUTES, SECTIONS } from "./routes";

/** The page at this address. */
export function Pages() {
  const text = useText();
  const [place] = useLocation();
  const named = SECTIONS.flat().find((page) => leadsTo(page, place));
  const title = named ? text(named.name) : "";
  useEffect(() => {
    document.title = title ? `${title} · trueloop` : "trueloop";
  }, [title]);
  return (
    <Fault of={place}>
      <Suspense fallback={<Loader aria-label={text("loading")} />}>
        <Switch>
          {ROUTES.map(({ path, page: Page }) => (
            <Route key={path} path={path}>
              {(found) => <Page key={place} id={piece(found, "id")} of={piece(found, "of")} />}
            </Route>
          ))}
          <Route>
            <p>{text("frame.nothing")}</p>
          </Route>
        </Switch>
      </Suspense>
    </Fault>
  );
}

/** A piece of the address as it was written; one that was no code stays as it is. */
function piece(found: Record<string, string | undefined>, name: string): string {
  const given = found[name] ?? "";
  try {
    return decodeURIComponent(given);
  } catch {
    return given;
  }
}
