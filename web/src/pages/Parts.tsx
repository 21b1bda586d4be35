import { Button, NativeSelect, TextInput } from "@mantine/core";
import { useState, type FormEvent } from "react";

import { usePages } from "../api/asking";
import type { Shape } from "../api/client";
import { Age, Head, More, Rows, Section, Shown, State, To } from "../show/parts";
import { useName, useText } from "../text/text";

const STATES = [
  ...["planned", "roughed", "semifinished", "probed", "corrected", "finished"],
  ...["inspected", "removed", "measured", "released", "rejected", "held"],
];

/** All parts, the latest first; found by serial number and state. */
export default function Parts() {
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
