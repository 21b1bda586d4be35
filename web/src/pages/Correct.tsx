import { useState } from "react";

import type { Shape } from "../api/client";
import { Head } from "../show/parts";
import { useText } from "../text/text";
import { Given } from "./correct/Given";
import { Measure } from "./correct/Measure";

export interface Seen {
  asked: Shape<"AskedPart">;
  part: Shape<"PartByHand">;
  file: Shape<"UploadView"> | undefined;
}

/** A part corrected by a person: program, what was measured, and what to enter or to run. */
export default function Correct() {
  const text = useText();
  const [seen, show] = useState<Seen>();
  return (
    <>
      <Head title={text("page.correct")} />
      <Given show={show} />
      {seen && <Measure key={JSON.stringify(seen.asked) + (seen.file?.sha256 ?? "")} {...seen} />}
    </>
  );
}
