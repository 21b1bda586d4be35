import { Button, NativeSelect, TextInput } from "@mantine/core";
import { type FormEvent, useState } from "react";

import { usePages, useShown } from "../api/asking";
import { piece, type Shape } from "../api/client";
import { useLengths } from "../show/lengths";
import { Age, Head, More, Rows, Section, Shown, State, To } from "../show/parts";
import { useName, useText } from "../text/text";
import { Certified } from "./part/Certified";
import { Decide } from "./part/Decide";
import { Corrections, Inspections } from "./part/Measured";

type Life = Shape<"PartLife">;

/** All that is known of a part, and what is to be decided of it. */
export default function PartLife({ id }: { id: string }) {
  const text = useText();
  const found = useShown<Life>(`parts/${encodeURIComponent(id)}/life`);
  return (
    <>
      <Head title={found.data?.label ?? text("page.parts")}>
        {found.data && <State kind="state" name={found.data.part.state} />}
        {found.data && found.data.inspections.length > 0 && (
          <To href={`/diagnosis/${piece(found.data.part.part_type)}/parts/${piece(found.data.part.serial)}`}>{text("page.diagnosis")}</To>
        )}
      </Head>
      <Shown found={found}>
        {(life) => (
          <>
            <About life={life} />
            {life.part.order && <Decide life={life} />}
            <Section title={text("part.route")}>
              <Steps life={life} />
            </Section>
            <Section title={text("part.inspections")}>
              <Inspections life={life} />
            </Section>
            <Section title={text("part.corrections")}>
              <Corrections life={life} />
            </Section>
            <Section title={text("part.certificates")}>
              <Certified life={life} />
            </Section>
            <Section title={text("part.events")}>
              <Events life={life} />
            </Section>
          </>
        )}
      </Shown>
    </>
  );
}

function About({ life: { part, tool } }: { life: Life }) {
  const text = useText();
  return (
    <div className="soft">
      {part.part_type} {part.revision} · {part.machine} · <Age at={part.changed_at} />
      {tool && (
        <>
          {" "}
          · {text("part.tool")} {tool}
        </>
      )}
      {part.order && (
        <>
          {" "}
          · <To href={`/orders/${encodeURIComponent(part.order)}`}>{text("order.of", { id: part.order })}</To>
        </>
      )}
    </div>
  );
}

function Steps({ life }: { life: Life }) {
  const text = useText();
  const word = useName();
  const next = life.steps.find((one) => one.state !== "recorded");
  return (
    <Rows
      label={text("part.route")}
      none={text("part.no.order")}
      head={(["step", "state", "attempts", "facts"] as const).map((one) => text(`head.${one}`))}
      rows={life.steps.map((one) => ({
        key: one.no,
        look: one === next && life.part.state === "held" ? "bad" : "",
        cells: [
          `${one.no} ${word("kind", one.kind)}`,
          <State kind="step" name={one.state} />,
          one.attempts,
          one.facts.map((fact, k) => (
            <div key={k}>
              {word("step", fact.what)} <Age at={fact.at} /> <span className="soft">{fact.witness}</span>
            </div>
          )),
        ],
      }))}
    />
  );
}

function Events({ life }: { life: Life }) {
  const text = useText();
  return (
    <Rows
      label={text("part.events")}
      none={text("part.events.none")}
      head={(["at", "by", "what", "values"] as const).map((one) => text(`head.${one}`))}
      rows={life.events.map((one) => ({
        key: one.id,
        cells: [<Age at={one.at} />, one.who, one.what, <Values of={one.values} />],
      }))}
    />
  );
}

/** Names with their values; long hashes break over lines. */
function Values({ of }: { of: Record<string, string> }) {
  const { named } = useLengths();
  return (
    <>
      {Object.entries(of).map((one) => named(...one)).map(([name, value]) => (
        <div key={name}>
          <span className="soft">{name}</span> {value}
        </div>
      ))}
    </>
  );
}

const STATES = [
  ...["planned", "roughed", "semifinished", "probed", "corrected", "finished"],
  ...["inspected", "removed", "measured", "released", "rejected", "held"],
];

/** All parts, the latest first; found by serial number and state. */
export function Parts() {
  const text = useText();
  const word = useName();
  const [typed, type] = useState("");
  const [serial, find] = useState("");
  const [state, choose] = useState("");
  const asked = new URLSearchParams({ ...(serial && { serial }), ...(state && { state }) }).toString();
  const list = usePages<Shape<"PartRow">>(asked ? `parts?${asked}` : "parts");

  function submit(event: FormEvent) {
    event.preventDefault();
    find(typed.trim());
  }
  return (
    <>
      <Head title={text("page.parts")} />
      <Section title={text("page.parts")}>
        <form className="fields" onSubmit={submit}>
          <div className="two">
            <TextInput label={text("part.search")} value={typed} onChange={(event) => type(event.currentTarget.value)} />
            <NativeSelect
              label={text("head.state")}
              value={state}
              onChange={(event) => choose(event.currentTarget.value)}
              data={[
                { value: "", label: text("part.all") },
                ...STATES.map((one) => ({ value: one, label: word("state", one) })),
              ]}
            />
            <Button type="submit" variant="default">
              {text("part.find")}
            </Button>
          </div>
        </form>
        <Shown found={list}>{(parts) => <PartRows parts={parts} />}</Shown>
        <More list={list} />
      </Section>
    </>
  );
}

function PartRows({ parts }: { parts: Shape<"PartRow">[] }) {
  const text = useText();
  return (
    <Rows
      label={text("page.parts")}
      none={text("part.none")}
      head={(["serial", "part_type", "state", "order", "machine", "changed"] as const).map((one) => text(`head.${one}`))}
      rows={parts.map((one) => ({
        key: one.id,
        look: one.state === "held" ? "bad" : "",
        cells: [
          <To href={`/parts/${one.id}`}>{one.serial}</To>,
          `${one.part_type} ${one.revision}`,
          <State kind="state" name={one.state} />,
          one.order && <To href={`/orders/${encodeURIComponent(one.order)}`}>{one.order}</To>,
          one.machine,
          <Age at={one.changed_at} />,
        ],
      }))}
    />
  );
}
