import { piece, type Shape } from "../../api/client";
import { hash } from "../../show/format";
import { useLengths } from "../../show/lengths";
import { Age, Length, Opens, Rows, SizeDeviation, State, To } from "../../show/parts";
import { Picture } from "../../show/Picture";
import { useProgramName } from "../../show/program";
import { useName, useText } from "../../text/text";

type Life = Shape<"PartLife">;
type Result = Shape<"Result">;

/** What was measured, and each characteristic against its limits. */
export function Inspections({ life }: { life: Life }) {
  const text = useText();
  const word = useName();
  const results = life.inspections.flatMap((one) => one.results.map((result, k) => ({ ...result, key: `${one.id} ${k}` })));
  return (
    <>
      <Rows
        label={text("part.inspections")}
        none={text("part.inspections.none")}
        head={(["source", "stage", "at", "touches", "rms"] as const).map((one) => text(`head.${one}`))}
        rows={life.inspections.map((one) => ({
          key: one.id,
          cells: [
            one.source,
            word("kind", one.stage),
            <Age at={one.at} />,
            one.touches,
            <Length of="um" value={one.rms_um} />,
          ],
        }))}
      />
      {results.length > 0 && <Results results={results} />}
    </>
  );
}

function Results({ results }: { results: (Result & { key: string })[] }) {
  const text = useText();
  const { name, plain } = useLengths();
  const heads = ["characteristic", "nominal", "limits", "actual", "deviation", "verdict"] as const;
  return (
    <>
      <Rows
        label={text("head.characteristic")}
        none=""
        head={heads.map((one) => text(`head.${one}`))}
        rows={results.map((one) => ({
          key: one.key,
          look: one.verdict === "out" ? "bad" : "",
          cells: [
            one.characteristic,
            <span className="number">
              {plain(one.unit, one.nominal)} {name(one.unit)}
            </span>,
            <>
              <span className="number">{plain(one.unit, one.lower_limit)} …</span>{" "}
              <span className="number">
                {plain(one.unit, one.upper_limit)} {name(one.unit)}
              </span>
            </>,
            <span className="number">
              {plain(one.unit, one.actual)} {name(one.unit)}
            </span>,
            <SizeDeviation um={one.deviation_um} />,
            <State kind="verdict" name={one.verdict} />,
          ],
        }))}
      />
      <p className="soft">{text("key.size")}</p>
    </>
  );
}

/** What was corrected, by whom, and how the program was changed. */
export function Corrections({ life }: { life: Life }) {
  const text = useText();
  const { corrected } = useProgramName();
  const changed = life.corrections.some((one) => one.corrected_sha256);
  const heads = ["correction", "at", "by", "what", ...(changed ? (["diff"] as const) : []), "open"] as const;
  const last = life.corrections.filter((one) => one.has_report).at(-1);
  return (
    <>
      <Rows
        label={text("part.corrections")}
        none={text("part.corrections.none")}
        head={heads.map((one) => text(`head.${one}`))}
        rows={life.corrections.map((one) => ({
          key: one.id,
          cells: [
            <code>{hash(one.id)}</code>,
            <Age at={one.made_at} />,
            one.made_by,
            <Summary of={one.summary} />,
            ...(changed
              ? [
                  one.source_sha256 && one.corrected_sha256 && (
                    <To href={`/programs/${one.source_sha256}/diff/${one.corrected_sha256}`}>
                      {one.source || hash(one.source_sha256)} →{" "}
                      {corrected({ name: one.source, serial: life.part.serial, revision: life.part.revision })}
                    </To>
                  ),
                ]
              : []),
            one.has_report && (
              <Opens href={`corrections/${encodeURIComponent(one.id)}/report?language=${document.documentElement.lang}`}>
                {text("correction.open")}
              </Opens>
            ),
          ],
        }))}
      />
      {last && (
        <figure className="curve">
          <Picture path={`corrections/${piece(last.id)}/sources`} said={text("sources.said")} sizes />
          <figcaption className="soft">{text("sources.key")}</figcaption>
        </figure>
      )}
    </>
  );
}

/** The first sentence of a decision; the others below it when it is opened. */
function Summary({ of: [first, ...others] }: { of: string[] }) {
  if (others.length === 0) return <>{first}</>;
  return (
    <details>
      <summary>{first}</summary>
      {others.map((line) => (
        <div key={line}>{line}</div>
      ))}
    </details>
  );
}
