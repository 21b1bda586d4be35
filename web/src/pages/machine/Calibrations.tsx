import { useChange } from "../../api/asking";
import { piece, type Shape } from "../../api/client";
import { useLengths } from "../../show/lengths";
import { Act, Age, Refused, Rows, Section, useWhyNot } from "../../show/parts";
import { useText } from "../../text/text";

/** When the machine's probe was calibrated; an operator tells that it was now. */
export function Calibrations({ machine }: { machine: Shape<"MachineView"> }) {
  const text = useText();
  const whyNot = useWhyNot();
  const { named } = useLengths();
  const change = useChange();
  return (
    <Section title={text("machine.calibrations")}>
      <Rows
        label={text("machine.calibrations")}
        none={text("machine.calibrations.none")}
        head={(["at", "values", "by"] as const).map((one) => text(`head.${one}`))}
        rows={machine.calibrations.map((one) => ({
          key: one.at,
          cells: [
            <Age at={one.at} />,
            Object.entries(one.values)
              .map((one) => named(...one).join(" "))
              .join(", "),
            one.who,
          ],
        }))}
      />
      <div className="fields">
        <Refused problem={change.error} />
        <Act
          label={text("machine.calibrated")}
          busy={change.isPending}
          why={whyNot("operator")}
          onClick={() => change.mutate({ path: `machines/${piece(machine.now.name)}/calibrated`, body: { values: {} } })}
        />
      </div>
    </Section>
  );
}
