import type { Shape } from "../api/client";
import { useText } from "../text/text";
import { hash } from "./format";

interface Made {
  name: string;
  serial: string;
  revision: string;
}

/** What a program is called: by its file, by what it was corrected from and for, or else by its hash. */
export function useProgramName() {
  const text = useText();
  const corrected = ({ name, serial, revision }: Made) =>
    text(revision ? "program.corrected.rev" : "program.corrected", { name: name || "–", serial, revision });
  const name = (one: Shape<"ProgramRow">) => one.name || (one.corrected ? corrected(one.corrected) : hash(one.sha256));
  return { name, corrected };
}
