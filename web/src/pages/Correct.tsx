import { NativeSelect } from "@mantine/core";
import { useIsMutating } from "@tanstack/react-query";
import { useState } from "react";

import type { Shape } from "../api/client";
import { Head } from "../show/parts";
import { ByFields, useText } from "../text/text";
import { Given, type Files } from "./correct/Given";
import { Milled } from "./correct/Milled";
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
  const [kind, choose] = useState("turned");
  const [files, keep] = useState<Files>({ programs: [] });
  const [seen, show] = useState<Seen>();
  const [done, made] = useState<Made>();
  return (
    <ByFields.Provider value>
      <Head title={text("page.correct")}>
        <NativeSelect
          aria-label={text("correct.kind")}
          value={kind}
          disabled={busy}
          onChange={(event) => choose(event.currentTarget.value)}
          data={(["turned", "milled"] as const).map((value) => ({ value, label: text(`correct.kind.${value}`) }))}
        />
      </Head>
      {kind === "milled" && (
        <fieldset className="unframed" disabled={busy}>
          <Milled />
        </fieldset>
      )}
      <fieldset className="unframed" disabled={busy} hidden={kind !== "turned"}>
        <Given files={files} keep={keep} busy={busy} show={(next) => (show(next), made(undefined))} />
        {seen && (
          <Measure
            key={JSON.stringify(seen.asked)}
            {...seen}
            changed={() => made(undefined)}
            done={made}
            next={(part) => {
              keep((all) => ({ ...all, measurement: undefined }));
              show(part && { ...seen, part, file: undefined });
            }}
          />
        )}
      </fieldset>
      {kind === "turned" && done && <Result key={done.id} made={done} />}
    </ByFields.Provider>
  );
}
