import { Progress } from "@mantine/core";

import { useShown } from "../api/asking";
import { piece, type Shape } from "../api/client";
import { hash, number } from "../show/format";
import { Age, Head, Outcome, Rows, Section, Shown, State, To } from "../show/parts";
import { useName, useText } from "../text/text";
import { Machines as MachineRows } from "./Today";
import { Calibrations } from "./machine/Calibrations";
import { Corrector } from "./machine/Corrector";
import { Temperatures } from "./machine/Temperatures";

type View = Shape<"MachineView">;
const EVERY_S = 2;

/** One machine: what it does, its corrector as it works, temperatures, calibrations and transfers. */
export default function MachinePage({ id }: { id: string }) {
  const text = useText();
  const found = useShown<View>(`machines/${piece(id)}`, EVERY_S);
  return (
    <>
      <Head title={id}>{found.data && <Age at={found.data.now.at} stale={found.data.now.stale} />}</Head>
      <Shown found={found}>
        {(machine) => (
          <>
            <Section title={text("machine.now")}>
              <Now machine={machine} />
            </Section>
            <Corrector machine={id} />
            <Temperatures machine={machine} />
            <Calibrations machine={machine} />
            <Section title={text("settings.transfers")}>
              <Transfers machine={machine} />
            </Section>
          </>
        )}
      </Shown>
    </>
  );
}

function Now({ machine: { now, part_id, model_version, keys } }: { machine: View }) {
  const text = useText();
  const word = useName();
  return (
    <dl className={now.stale ? "facts stale" : "facts"}>
      <dt>{text("head.state")}</dt>
      <dd>{now.state || "–"}</dd>
      <dt>{text("head.step")}</dt>
      <dd>{now.block ? <>{word("kind", now.block)} <State kind="step" name={now.step_state} /></> : "–"}</dd>
      <dt>{text("head.order")}</dt>
      <dd>{now.order ? <To href={`/orders/${piece(now.order)}`}>{now.order}</To> : "–"}</dd>
      <dt>{text("head.part")}</dt>
      <dd>{part_id === null ? "–" : <To href={`/parts/${part_id}`}>{now.part}</To>}</dd>
      <dt>{text("head.program")}</dt>
      <dd>
        {now.program || "–"} {now.line != null && <span className="number">N{now.line}</span>}
        {now.progress != null && (
          <Progress value={now.progress * 100} size="lg" aria-label={`${now.name} ${number(now.progress * 100, 0)} %`} />
        )}
      </dd>
      <dt>{text("head.corrector")}</dt>
      <dd>{now.corrector || "–"}</dd>
      <dt>{text("machine.model")}</dt>
      <dd>{model_version ? <code>{hash(model_version)}</code> : text("machine.model.none")}</dd>
      <dt>{text("machine.keys")}</dt>
      <dd>{keys}</dd>
    </dl>
  );
}

function Transfers({ machine }: { machine: View }) {
  const text = useText();
  const word = useName();
  return (
    <Rows
      label={text("settings.transfers")}
      none={text("settings.transfers.none")}
      head={(["program", "at", "direction", "outcome", "by"] as const).map((one) => text(`head.${one}`))}
      rows={machine.transfers.map((one) => ({
        key: one.id,
        cells: [
          one.program,
          <Age at={one.at} />,
          word("direction", one.direction),
          <Outcome said={one.outcome} />,
          one.who,
        ],
      }))}
    />
  );
}

/** All machines as last heard; each leads to its own page. */
export function Machines() {
  const text = useText();
  const found = useShown<{ items: Shape<"MachineNow">[] }>("machines", EVERY_S);
  return (
    <>
      <Head title={text("page.machines")} />
      <Section title={text("page.machines")}>
        <Shown found={found}>{({ items }) => <MachineRows machines={items} />}</Shown>
      </Section>
    </>
  );
}
