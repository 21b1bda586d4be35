import { TextInput } from "@mantine/core";
import { useState } from "react";

import { useChange, usePages } from "../api/asking";
import type { Shape } from "../api/client";
import { Act, Age, Head, More, Refused, Rows, Section, Shown, useWhyNot } from "../show/parts";
import { useText } from "../text/text";

type Alarm = Shape<"AlarmView">;

/** Alarms, the latest first; those that nobody has acknowledged can be. */
export default function Alarms() {
  const text = useText();
  const list = usePages<Alarm>("alarms");
  return (
    <>
      <Head title={text("page.alarms")} />
      <Section title={text("page.alarms")}>
        <Shown found={list}>
          {(alarms) => (
            <Rows
              label={text("page.alarms")}
              none={text("alarm.none")}
              head={(["at", "alarm", "said", "acknowledged"] as const).map((one) => text(`head.${one}`))}
              rows={alarms.map((one) => ({
                key: one.id,
                look: one.acknowledged_by ? "" : "bad",
                cells: [
                  <Age at={one.at} />,
                  <>
                    {one.source} <code>{one.code}</code>
                  </>,
                  one.said,
                  <Acknowledged alarm={one} />,
                ],
              }))}
            />
          )}
        </Shown>
        <More list={list} />
      </Section>
    </>
  );
}

function Acknowledged({ alarm }: { alarm: Alarm }) {
  const text = useText();
  const whyNot = useWhyNot();
  const [why, write] = useState("");
  const change = useChange();
  if (alarm.acknowledged_by) {
    return (
      <>
        {alarm.acknowledged_by} <Age at={alarm.acknowledged_at} />
      </>
    );
  }
  return (
    <div className="fields">
      <TextInput
        label={text("act.why")}
        maxLength={2000}
        value={why}
        onChange={(event) => write(event.currentTarget.value)}
      />
      <Refused problem={change.error} />
      <Act
        label={text("action.acknowledge")}
        busy={change.isPending}
        why={whyNot("operator") || (why.trim() ? "" : text("act.why.missing"))}
        onClick={() => change.mutate({ path: `alarms/${alarm.id}/acknowledge`, body: { why: why.trim() } })}
      />
    </div>
  );
}
