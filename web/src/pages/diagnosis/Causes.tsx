import type { Shape } from "../../api/client";
import { number } from "../../show/format";
import { useLengths } from "../../show/lengths";
import { Section } from "../../show/parts";
import { useText } from "../../text/text";

type Candidate = Shape<"CandidateShape">;
const SHOWN = 0.01;

/** What acts, likeliest first: evidence for and against, what to do, and which measurement would decide. */
export function Causes({ causes }: { causes: Shape<"CausesShape"> | null }) {
  const text = useText();
  if (!causes) return <p>{text("diagnosis.nothing")}</p>;
  const shown = causes.candidates.filter((one) => one.probability >= SHOWN);
  return (
    <>
      <Section title={text("diagnosis.causes")}>
        <p>{text("diagnosis.sound", { percent: percent(causes.sound) })}</p>
        {causes.decide.length > 0 && (
          <>
            <h3 className="small">{text("diagnosis.decide")}</h3>
            <ul className="remarks">
              {causes.decide.map((one) => (
                <li key={one}>{one}</li>
              ))}
            </ul>
          </>
        )}
      </Section>
      {shown.map((one) => (
        <Section key={`${one.key} ${one.tool}`} title={`${percent(one.probability)} % ${one.name}${one.tool ? ` (${one.tool})` : ""}`}>
          <Facts one={one} />
        </Section>
      ))}
    </>
  );
}

function Facts({ one }: { one: Candidate }) {
  const text = useText();
  const { name, plain, signed } = useLengths();
  return (
    <>
      <div className="probability" aria-hidden>
        <progress value={one.probability} max={1} />
      </div>
      <dl className="facts">
        <dt>{text("diagnosis.size")}</dt>
        <dd className="number">{`${signed("um", one.size_um)} ± ${plain("um", one.standard_u_um)} ${name("um")}`}</dd>
        <dt>{text("diagnosis.features")}</dt>
        <dd>{one.features.join(", ") || "–"}</dd>
        <dt>{text("diagnosis.supports")}</dt>
        <dd>{one.supports.join(" ") || "–"}</dd>
        <dt>{text("diagnosis.contradicts")}</dt>
        <dd>{one.contradicts.join(" ") || "–"}</dd>
        <dt>{text("diagnosis.remedy")}</dt>
        <dd>{one.remedy}</dd>
        <dt>{text("diagnosis.decided")}</dt>
        <dd>{one.decided_by}</dd>
      </dl>
    </>
  );
}

function percent(share: number): string {
  return share > 0 && share < 0.005 ? "<1" : number(100 * share, 0);
}
