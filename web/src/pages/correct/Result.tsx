import { NativeSelect } from "@mantine/core";
import { useState } from "react";

import type { Shape } from "../../api/client";
import { useReader } from "../../show/lengths";
import { Deviation, Legend, Length, Notes, Opens, Rows, Section } from "../../show/parts";
import { useName, useText } from "../../text/text";
import { Remarks } from "../files/Content";
import { Drawn } from "./Measure";

type Made = Shape<"CorrectedByHand">;

/** What to enter at the control, or the program to run: one of them. And what to expect of the next cut. */
export function Result({ made }: { made: Made }) {
  const text = useText();
  const word = useName();
  const reader = useReader();
  const [chosen, choose] = useState(made.ways[0]?.by);
  const way = made.ways.find((one) => one.by === chosen);
  const first = made.ways[0];
  const name = way?.program ?? "";
  const sha = (program: string) => made.files.find((one) => one.name === program)?.sha256 ?? "";
  const toRun = made.to_run ?? [];
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
              {!way.given && <Download sha={sha(name)} name={name} />}
            </>
          )}
          {toRun.map((one) => (
            <div key={one.setup}>
              {one.setup && <h3 className="small">{text("correct.setup.named", { name: one.setup, program: one.program })}</h3>}
              {one.entered.map((words) => (
                <p key={words}>
                  <strong className="enter">{words}</strong>
                </p>
              ))}
              <p>{text(one.entered.length ? "correct.do.enter" : one.given ? "correct.do.as.is" : "correct.do.run", { program: one.program })}</p>
              {one.blocks.length > 0 && (
                <p>
                  {text("correct.do.block")} <code>{one.blocks.join(" ")}</code>
                </p>
              )}
              {!one.given && <Download sha={sha(one.program)} name={one.program} />}
            </div>
          ))}
        </div>
        <Remarks of={made.remarks} />
        <p className={made.kept ? "soft" : "why"}>{text(made.kept ? "correct.kept" : "correct.kept.not")}</p>
      </Section>
      <Section title={text("correct.expected")}>
        {made.ways.length > 1 && first && <p>{text("correct.expected.of", { way: word("correct.way", first.by) })}</p>}
        <p>{made.headline}</p>
        <p className="soft">{text("key.side")}</p>
        <Legend />
        {made.pictures.map((one) => (
          <figure key={one.said} className="of-tool">
            <Drawn of={one} />
            {toRun.length > 0 && <figcaption className="soft">{one.said}</figcaption>}
          </figure>
        ))}
        <Rows
          label={text("correct.expected")}
          none=""
          head={[text("head.feature"), text("head.touches"), text("correct.before"), text("correct.after"), text("head.expanded"), text("head.correction")]}
          rows={made.features.map((one) => ({
            key: `${one.cut_by} ${one.feature}`,
            cells: [
              one.cut_by ? `${one.feature} (${one.cut_by})` : one.feature,
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
        {made.kept && toRun.length === 0 && <Opens href={`corrections/${made.id}/report?${reader}`}>{text("correction.open")}</Opens>}
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

export function Download({ sha, name }: { sha: string; name: string }) {
  const text = useText();
  return (
    <a className="to" href={`/api/v1/uploads/${sha}/file`} download={name}>
      {text("correct.download", { name })}
    </a>
  );
}
