import type { Shape } from "../../api/client";
import { useLengths } from "../../show/lengths";
import { Rows, State } from "../../show/parts";
import { useHint, useName, useText } from "../../text/text";

type View = Shape<"UploadView">;
type Inspection = Shape<"InspectionRead">;

/** What a file was read as, or why it could not be read. */
export function Content({ view: { program, measurement, drawing, problem } }: { view: View }) {
  const text = useText();
  const word = useName();
  return (
    <>
      {problem && <Remarks of={[problem]} />}
      {program && (
        <>
          <p>
            {text("file.program")}: {word("dialect", program.dialect)} {program.unit} · {text("file.blocks", { count: program.blocks })}
          </p>
          <Remarks of={program.remarks} />
        </>
      )}
      {measurement && (
        <>
          <p>
            {text("file.measurement")}: {measurement.format} {measurement.unit}
          </p>
          <Remarks of={measurement.remarks} />
          {measurement.inspections.map((one) => (
            <Values key={one.run} inspection={one} />
          ))}
        </>
      )}
      {drawing && (
        <pre className="text" tabIndex={0} role="region" aria-label={text("file.drawing")}>
          {drawing.part_toml}
        </pre>
      )}
    </>
  );
}

/** What is odd about a file, each with its code and what to do. */
export function Remarks({ of }: { of: Shape<"Remarked">[] }) {
  const hinted = useHint();
  return (
    <ul className="remarks">
      {of.map((one, k) => (
        <li key={k} className={one.severity === "error" ? "why" : "soft"}>
          {one.code && <code>{one.code}</code>} {one.said} – {hinted(one)}
        </li>
      ))}
    </ul>
  );
}

const HEAD = ["characteristic", "feature", "nominal", "limits", "actual", "difference", "unit", "verdict"] as const;

function Values({ inspection }: { inspection: Inspection }) {
  const text = useText();
  const { name, plain } = useLengths();
  const { run, serial, measured_at, count, values, remarks } = inspection;
  return (
    <>
      <p>
        {text("file.inspection", { run, count })} {serial} {measured_at}
      </p>
      <Remarks of={remarks} />
      <Rows
        label={text("file.inspection", { run, count })}
        none=""
        head={HEAD.map((one) => text(`head.${one}`))}
        rows={values.map((one, k) => ({
          key: k,
          look: one.within === false ? "bad" : "",
          cells: [
            `${one.characteristic} ${one.quantity}`,
            one.feature || one.reason,
            <span className="number">{plain(one.unit, one.nominal)}</span>,
            one.within !== null && (
              <span className="number">
                {plain(one.unit, one.lower_limit)} … {plain(one.unit, one.upper_limit)}
              </span>
            ),
            <span className="number">{plain(one.unit, one.actual)}</span>,
            <span className="number">{plain(one.unit, one.deviation)}</span>,
            name(one.unit),
            <State kind="verdict" name={one.within === null ? "none" : one.within ? "in" : "out"} />,
          ],
        }))}
      />
    </>
  );
}
