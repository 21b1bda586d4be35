import { NativeSelect, TextInput } from "@mantine/core";
import { useState } from "react";

import { useChange, usePages } from "../api/asking";
import type { Shape } from "../api/client";
import { hash } from "../show/format";
import { Act, Age, Head, More, Opens, Refused, Rows, Section, Shown, State, To, useWhyNot } from "../show/parts";
import { useProgramName } from "../show/program";
import { useName, useText } from "../text/text";

type Program = Shape<"ProgramRow">;
const HEAD = ["program", "hash", "dialect", "kept", "open", "released"] as const;

/** All programs, the latest first; an engineer releases them, and two of them can be compared. */
export default function Programs() {
  const text = useText();
  const word = useName();
  const { name } = useProgramName();
  const list = usePages<Program>("programs");
  return (
    <>
      <Head title={text("page.programs")}>
        <To href="/files">{text("page.files")}</To>
      </Head>
      <Section title={text("page.programs")}>
        <Shown found={list}>
          {(programs) => (
            <Rows
              label={text("page.programs")}
              none={text("program.none")}
              head={HEAD.map((one) => text(`head.${one}`))}
              rows={programs.map((one) => ({
                key: one.sha256,
                cells: [
                  <>
                    {name(one)}
                    {one.corrected && (
                      <To href={`/programs/${one.corrected.source_sha256}/diff/${one.sha256}`}>{text("head.diff")}</To>
                    )}
                  </>,
                  <code className="number">{hash(one.sha256)}</code>,
                  `${word("dialect", one.dialect)} ${one.unit}`,
                  <Age at={one.kept_at} />,
                  <Opens href={`programs/${one.sha256}`}>{text("program.open")}</Opens>,
                  one.released ? <State kind="state" name="released" /> : <Release sha256={one.sha256} />,
                ],
              }))}
            />
          )}
        </Shown>
        <More list={list} />
      </Section>
      {(list.data?.length ?? 0) > 1 && (
        <Section title={text("program.compare")}>
          <Compare programs={list.data ?? []} />
        </Section>
      )}
    </>
  );
}

function Release({ sha256 }: { sha256: string }) {
  const text = useText();
  const whyNot = useWhyNot();
  const [why, write] = useState("");
  const change = useChange();
  return (
    <div className="fields">
      <TextInput label={text("act.why")} maxLength={2000} value={why} onChange={(event) => write(event.currentTarget.value)} />
      <Refused problem={change.error} />
      <Act
        label={text("action.release")}
        busy={change.isPending}
        why={whyNot("engineer") || (why.trim() ? "" : text("act.why.missing"))}
        onClick={() => change.mutate({ path: `programs/${sha256}/release`, body: { why: why.trim() } })}
      />
    </div>
  );
}

function Compare({ programs }: { programs: Program[] }) {
  const text = useText();
  const { name } = useProgramName();
  const [before, from] = useState("");
  const [after, to] = useState("");
  const data = [
    { value: "", label: text("order.program.none") },
    ...programs.map((one) => ({ value: one.sha256, label: `${name(one)} ${hash(one.sha256)}` })),
  ];
  return (
    <div className="fields">
      <div className="two">
        <NativeSelect
          label={text("program.before")}
          value={before}
          onChange={(event) => from(event.currentTarget.value)}
          data={data}
        />
        <NativeSelect
          label={text("program.after")}
          value={after}
          onChange={(event) => to(event.currentTarget.value)}
          data={data}
        />
      </div>
      {before && after && <To href={`/programs/${before}/diff/${after}`}>{text("head.diff")}</To>}
    </div>
  );
}
