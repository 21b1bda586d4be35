import { useShown } from "../../api/asking";
import { piece, type Shape } from "../../api/client";
import { useLengths, useReader } from "../../show/lengths";
import { Age, Deviation, Head, Length, Rows, Section, Shown, To } from "../../show/parts";
import { useName, useText } from "../../text/text";
import { Findings } from "../Charts";
import { Causes } from "./Causes";

type View = Shape<"PartDiagnosisShape">;

/** What is wrong with one part, as far as it tells. */
export default function OfPart({ id, of }: { id: string; of: string }) {
  const text = useText();
  const asked = `part_type=${piece(of)}&${useReader()}`;
  const found = useShown<View>(`diagnosis/part/${piece(id)}?${asked}`);
  return (
    <>
      <Head title={`${text("page.diagnosis")}: ${id}, ${of}`}>
        <To href={`/diagnosis/${piece(of)}`}>{text("diagnosis.series")}</To>
      </Head>
      <Shown found={found}>
        {(view) => (
          <>
            <p className="soft">
              {text("diagnosis.cut")} <Age at={view.part.at} />. {text("diagnosis.signs")}
            </p>
            <Causes causes={view.causes} />
            <Section title={text("diagnosis.errors")}>
              <Errors view={view} />
            </Section>
            {view.points.length > 0 && (
              <Section title={text("diagnosis.points")}>
                <Points view={view} />
              </Section>
            )}
            <Findings findings={view.findings} />
          </>
        )}
      </Shown>
    </>
  );
}

function Errors({ view }: { view: View }) {
  const text = useText();
  const { name } = useLengths();
  const word = useName();
  const rows = Object.entries(view.part.errors).flatMap(([device, errors]) => errors.map((one) => ({ device, one })));
  return (
    <Rows
      label={text("diagnosis.errors")}
      none={text("diagnosis.errors.none")}
      head={[text("head.feature"), text("diagnosis.error"), text("head.source"), name("um"), text("head.u")]}
      rows={rows.map(({ device, one }) => ({
        key: `${device} ${one.feature} ${one.kind} ${one.other}`,
        cells: [
          one.feature + (one.other ? `, ${one.other}` : ""),
          word("error", one.kind),
          word("device", device),
          <Deviation um={one.value_um} />,
          <Length of="um" value={one.standard_u_um} />,
        ],
      }))}
    />
  );
}

const POINT = ["ERROR_PP", "ERROR_MTG", "ERROR_PROC", "RESID_MTG", "RESID_PROC"];

function Points({ view }: { view: View }) {
  const text = useText();
  const { name } = useLengths();
  return (
    <Rows
      label={text("diagnosis.points")}
      none=""
      head={[text("head.name"), ...POINT.map((one) => `${one} ${name("um")}`)]}
      rows={view.points.map((one) => ({
        key: one.name,
        cells: [
          one.name,
          <Deviation um={one.error_pp_um} />,
          <Deviation um={one.error_mtg_um} />,
          <Deviation um={one.error_proc_um} />,
          <Deviation um={one.error_mtg_resid_um} />,
          <Deviation um={one.error_proc_resid_um} />,
        ],
      }))}
    />
  );
}
