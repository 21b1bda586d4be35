import { useIsMutating } from "@tanstack/react-query";
import { useState } from "react";

import type { Shape } from "../api/client";
import { Head } from "../show/parts";
import { useText } from "../text/text";
import { Given, type Files } from "./correct/Given";
import { Measure } from "./correct/Measure";
import { Result } from "./correct/Result";

export interface Seen {
  asked: Shape<"AskedPart">;
  part: Shape<"PartByHand">;
  file: Shape<"UploadView"> | undefined;
}

type Made = Shape<"CorrectedByHand">;

/** A part corrected by a person: program, what was measured, and what to enter or to run. */
export default function Correct() {
  const text = useText();
  const busy = useIsMutating() > 0; // what is asked or corrected is what stands in the fields
  const [files, keep] = useState<Files>({});
  const [seen, show] = useState<Seen>();
  const [done, made] = useState<{ made: Made; given: string }>();
  return (
    <>
      <Head title={text("page.correct")} />
      <fieldset className="unframed" disabled={busy}>
        <Given files={files} keep={keep} busy={busy} show={(next) => (show(next), made(undefined))} />
        {seen && (
          <Measure
            key={JSON.stringify(seen.asked)}
            {...seen}
            changed={() => made(undefined)}
            done={(one) => made({ made: one, given: seen.asked.program })}
            next={(part) => {
              keep((all) => ({ ...all, measurement: undefined }));
              show(part && { ...seen, part, file: undefined });
            }}
          />
        )}
      </fieldset>
      {done && <Result key={done.made.id} made={done.made} given={done.given} />}
    </>
  );
}
