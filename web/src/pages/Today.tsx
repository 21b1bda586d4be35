import { Progress } from "@mantine/core";

import { useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { number } from "../show/format";
import { Age, Head, Rows, Section, Shown, State, To, type Row } from "../show/parts";
import { may, useUser } from "../show/roles";
import { useName, useText, type Key } from "../text/text";

type Waiting = Shape<"Waiting">;
type MachineNow = Shape<"MachineNow">;
const EVERY_S = 2;

/** What waits for whom, what the machines do, what was made. */
export default function Today() {
  const text = useText();
  const me = useUser();
  const today = useShown<Shape<"Today">>("today", EVERY_S);
  return (
    <>
      <Head title={text("page.today")} />
      <Shown found={today}>
        {({ waiting, machines, made }) => {
          const mine = waiting.filter((one) => may(me.role, one.role));
          const others = waiting.filter((one) => !may(me.role, one.role));
          return (
            <>
              <Section title={text("today.you")}>
                <WaitingRows items={mine} label={text("today.you")} />
              </Section>
              <Section title={text("today.machines")}>
                <Machines machines={machines} />
              </Section>
              <Section title={text("today.made")}>
                <Counts made={made} />
              </Section>
              {others.length > 0 && (
                <Section title={text("today.others")}>
                  <WaitingRows items={others} label={text("today.others")} others />
                </Section>
              )}
            </>
          );
        }}
      </Shown>
    </>
  );
}

const PLACES: Record<string, (id: string) => string> = {
  order: (id) => `/orders/${encodeURIComponent(id)}`,
  part: (id) => `/parts/${encodeURIComponent(id)}`,
  proposal: (id) => `/proposals/${encodeURIComponent(id)}`,
  alarm: () => "/alarms",
};

function WaitingRows({ items, label, others = false }: { items: Waiting[]; label: string; others?: boolean }) {
  const text = useText();
  const word = useName();
  const head = ["head.action", "head.machine", "head.part", "head.said", "head.since"] as const;
  const rows: Row[] = items.map((one) => ({
    key: `${one.subject} ${one.id} ${one.action}`,
    look: one.action === "decide" || one.action === "acknowledge" ? "bad" : "",
    cells: [
      <To href={PLACES[one.subject]?.(one.id) ?? "/"}>{word("action", one.action)}</To>,
      one.machine,
      one.part,
      one.said,
      <Age at={one.since} />,
      ...(others ? [word("role", one.role)] : []),
    ],
  }));
  const titles = [...head, ...(others ? (["head.role"] as const) : [])].map((one) => text(one));
  return <Rows label={label} head={titles} rows={rows} none={text("today.you.none")} />;
}

/** Machines as last heard; those not heard for long are grey. */
export function Machines({ machines }: { machines: MachineNow[] }) {
  const text = useText();
  const heads = ["head.machine", "head.heard", "head.step", "head.part", "head.program", "head.corrector"] as const;
  const rows: Row[] = machines.map((one) => ({
    key: one.name,
    look: one.stale ? "stale" : "",
    cells: [
      <To href={`/machines/${encodeURIComponent(one.name)}`}>{one.name}</To>,
      <Age at={one.at} stale={one.stale} />,
      <Doing machine={one} />,
      one.part,
      <Running machine={one} />,
      one.corrector,
    ],
  }));
  return <Rows label={text("today.machines")} head={heads.map((one) => text(one))} rows={rows} none={text("today.machines.none")} />;
}

function Doing({ machine }: { machine: MachineNow }) {
  const word = useName();
  if (!machine.block) return <>{machine.state}</>;
  return (
    <>
      {word("kind", machine.block)} <State kind="step" name={machine.step_state} />
    </>
  );
}

function Running({ machine: { name, program, line, progress } }: { machine: MachineNow }) {
  if (!program) return null;
  return (
    <>
      {program} {line !== null && line !== undefined && <span className="number">N{line}</span>}
      {progress !== null && progress !== undefined && (
        <Progress value={progress * 100} size="lg" aria-label={`${name} ${number(progress * 100, 0)} %`} />
      )}
    </>
  );
}

const said = (one: Shape<"Cpk">) => ({ count: one.count, low: number(one.low, 2), high: number(one.high, 2) });

/** How many parts today, and of them how many were good. */
export function Counts({ made }: { made: Shape<"Made"> }) {
  const text = useText();
  const shown = ["made", "in_tolerance", "held", "rejected"] as const;
  return (
    <dl className="counts">
      {shown.map((one) => (
        <div key={one}>
          <dt>{text(`made.${one}` as Key)}</dt>
          <dd>{made[one]}</dd>
        </div>
      ))}
      {made.cpk.map((one) => (
        <div key={`${one.part_type} ${one.characteristic}`}>
          <dt>
            Cpk {one.characteristic}, {one.part_type}
            <br />
            {one.cpk === null ? text(one.count < one.needed ? "made.cpk.few" : "made.cpk.equal", { count: one.count, needed: one.needed }) : text("made.cpk", said(one))}
          </dt>
          <dd>{number(one.cpk, 2)}</dd>
        </div>
      ))}
    </dl>
  );
}
