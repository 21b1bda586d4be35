import { useShown } from "../../api/asking";
import { piece, type Shape } from "../../api/client";
import { useLengths, useReader } from "../../show/lengths";
import { Head, Rows, Section, Shown, To } from "../../show/parts";
import { useName, useText } from "../../text/text";
import { Findings } from "../Charts";
import { Causes } from "./Causes";

type View = Shape<"SeriesDiagnosisShape">;
type Mean = Shape<"MeanShape"> | null;

/** What makes the parts of a type wrong. */
export default function OfSeries({ id }: { id: string }) {
  const text = useText();
  const found = useShown<View>(`diagnosis/series/${piece(id)}?${useReader()}`);
  return (
    <>
      <Head title={`${text("page.diagnosis")}: ${id}`} />
      <Shown found={found}>
        {(view) => (
          <>
            <p className="soft">{text("diagnosis.signs")}</p>
            <Causes causes={view.causes} />
            <Section title={text("diagnosis.errors")}>
              <Means view={view} />
            </Section>
            <Section title={text("head.parts")}>
              <span className="acts">
                {view.parts.slice(-30).map((one) => (
                  <To key={one.serial} href={`/diagnosis/${piece(view.part_type)}/parts/${piece(one.serial)}`}>
                    {one.serial}
                  </To>
                ))}
              </span>
            </Section>
            <Findings findings={view.findings} />
          </>
        )}
      </Shown>
    </>
  );
}

function Means({ view }: { view: View }) {
  const text = useText();
  const word = useName();
  const { plain, signed } = useLengths();
  const odd = new Set(view.unexplained.map((one) => `${one.feature} ${one.kind} ${one.other}`));
  const mean = (one: Mean) =>
    one && (
      <span className="number">
        {signed("um", one.mean_um)} ± {plain("um", one.standard_u_um)}
      </span>
    );
  return (
    <Rows
      label={text("diagnosis.errors")}
      none={text("diagnosis.errors.none")}
      head={(["feature", "error", "machine", "cmm", "difference", "notes"] as const).map((one) =>
        one === "feature" || one === "notes" ? text(`head.${one}`) : text(`diagnosis.${one}`),
      )}
      rows={view.means.map((one) => ({
        key: `${one.feature} ${one.kind} ${one.other}`,
        cells: [
          one.feature + (one.other ? `, ${one.other}` : ""),
          word("error", one.kind),
          mean(one.machine),
          mean(one.cmm),
          mean(one.difference),
          odd.has(`${one.feature} ${one.kind} ${one.other}`) && text("diagnosis.unexplained"),
        ],
      }))}
    />
  );
}
