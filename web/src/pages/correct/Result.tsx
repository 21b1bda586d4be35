import { NativeSelect } from "@mantine/core";
import { useState } from "react";

import type { Shape } from "../../api/client";
import { useReader } from "../../show/lengths";
import { Deviation, Legend, Length, Notes, Opens, Rows, Section } from "../../show/parts";
import { useName, useText } from "../../text/text";
import { Remarks } from "../files/Content";
import { Drawn } from "./Drawn";

type Made = Shape<"CorrectedByHand">;

/** What to enter at the control, or the program to run: one of them. And what to expect of the next cut. */
export function Result({ made, given }: { made: Made; given: string }) {
  const text = useText();
  const word = useName();
  const reader = useReader();
  const [chosen, choose] = useState(made.ways[0]?.by);
  const way = made.ways.find((one) => one.by === chosen);
  const first = made.ways[0];
  const name = way?.program ?? "";
  const sha = way?.given ? given : made.files.find((one) => one.name === name)?.sha256;
  return (
    <>
      <Section title={text("correct.result")}>
        <div className="fields" role="status">
          {made.ways.length > 1 && (
            <NativeSelect
              label={text("correct.way")}
              value={chosen ?? ""}
              onChange={(event) => choose(made.ways.find((one) => one.by === event.currentTarget.value)?.by)}
              data={made.ways.map(({ by }) => ({ value: by, label: word("correct.way", by) }))}
            />
          )}
          {way && (
            <>
              {way.enter && <strong className="enter">{way.enter}</strong>}
              <p>{text(`correct.do.${way.by}`, { program: name })}</p>
              {way.leaves && <p>{text("correct.leaves", { left: way.leaves })}</p>}
              {way.blocks.length > 0 && (
                <p>
                  {text("correct.do.block")} <code>{way.blocks.join(" ")}</code>
                </p>
              )}
              {sha && !way.given && <Download sha={sha} name={name} />}
            </>
          )}
        </div>
        <Remarks of={made.remarks} />
        <p className={made.kept ? "soft" : "why"}>{text(made.kept ? "correct.kept" : "correct.kept.not")}</p>
      </Section>
      <Section title={text("correct.expected")}>
        {made.ways.length > 1 && first && <p>{text("correct.expected.of", { way: word("correct.way", first.by) })}</p>}
        <p>{made.headline}</p>
        <p className="soft">{text("key.side")}</p>
        <Legend />
        <Drawn of={made.picture} />
        <Rows
          label={text("correct.expected")}
          none=""
          head={[text("head.feature"), text("head.touches"), text("correct.before"), text("correct.after"), text("head.expanded"), text("head.correction")]}
          rows={made.features.map((one) => ({
            key: one.feature,
            cells: [
              one.feature,
              String(one.touches),
              <Deviation um={one.before_um} />,
              <Deviation um={one.expected_um} />,
              <Length of="um" value={one.expanded_u_um} digits={1} />,
              one.correction,
            ],
          }))}
        />
        <h3 className="small">{text("correct.notes")}</h3>
        <Notes of={made.notes} />
        {made.kept && <Opens href={`corrections/${made.id}/report?${reader}`}>{text("correction.open")}</Opens>}
        <h3 className="small">{text("correct.all")}</h3>
        <div className="acts">
          {made.files
            .filter((one) => !/^(corrected|offsets)\b/.test(one.name) || one.name === name)
            .map((one) => (
              <Download key={one.name} sha={one.sha256} name={one.name} />
            ))}
        </div>
      </Section>
    </>
  );
}

function Download({ sha, name }: { sha: string; name: string }) {
  const text = useText();
  return (
    <a className="to" href={`/api/v1/uploads/${sha}/file`} download={name}>
      {text("correct.download", { name })}
    </a>
  );
}
