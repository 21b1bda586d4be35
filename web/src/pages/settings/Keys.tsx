import { NativeSelect, TextInput, Title } from "@mantine/core";
import { useState } from "react";

import { useChange, useShown } from "../../api/asking";
import type { Shape } from "../../api/client";
import { moment } from "../../show/format";
import { Act, Age, Refused, Rows, Section, Shown, State } from "../../show/parts";
import { useName, useText } from "../../text/text";

type Key = Shape<"KeyRow">;
const HEADS = ["key", "machine", "what", "by", "since", "holds", "state"] as const;
const SCOPES = ["cell", "metrics"] as const;
const LONGEST_DAYS = 400;

/** All keys of programs; an administrator makes and ends them. */
export function Keys() {
  const text = useText();
  const word = useName();
  const found = useShown<Shape<"Keys">>("keys");
  return (
    <Section title={text("settings.keys")}>
      <Shown found={found}>
        {({ items }) => (
          <Rows
            label={text("settings.keys")}
            none={text("settings.keys.none")}
            head={HEADS.map((one) => text(one === "what" ? "settings.key.scope" : `head.${one}`))}
            rows={items.map((one) => ({
              key: one.id,
              look: stateOf(one) === "holds" ? "" : "stale",
              cells: [
                one.name,
                one.machine,
                word("scope", one.scope),
                one.made_by,
                <Age at={one.made_at} />,
                moment(one.ended_at ?? one.expires_at),
                <Ending key={one.id} one={one} />,
              ],
            }))}
          />
        )}
      </Shown>
      <Make />
    </Section>
  );
}

function stateOf(one: Key): "holds" | "ended" | "expired" {
  if (one.ended_at) return "ended";
  return new Date(one.expires_at).getTime() > Date.now() ? "holds" : "expired";
}

function Ending({ one }: { one: Key }) {
  const text = useText();
  const change = useChange();
  const state = stateOf(one);
  if (state !== "holds") return <State kind="key" name={state} />;
  return (
    <>
      <Refused problem={change.error} />
      <Act
        danger
        label={text("settings.key.end")}
        busy={change.isPending}
        onClick={() => change.mutate({ method: "DELETE", path: `keys/${one.id}` })}
      />
    </>
  );
}

function Make() {
  const text = useText();
  const [name, setName] = useState("");
  const [machine, setMachine] = useState("");
  const [scope, setScope] = useState<Key["scope"]>("cell");
  const [days, setDays] = useState("365");
  const making = useChange<Shape<"MadeKey"> | undefined>();
  const held = Number(days);
  const wrong = Number.isInteger(held) && held >= 1 && held <= LONGEST_DAYS ? "" : text("settings.key.days.wrong");
  const empty = name.trim() && (scope === "metrics" || machine.trim()) ? "" : text("settings.empty");
  const body = { name: name.trim(), machine: scope === "cell" ? machine.trim() : "", scope, days: held };
  return (
    <div className="fields">
      <Title order={3} size="h5">
        {text("settings.key.make")}
      </Title>
      <div className="two">
        <TextInput label={text("settings.key.name")} value={name} onChange={(event) => setName(event.currentTarget.value)} />
        <NativeSelect
          label={text("settings.key.scope")}
          value={scope}
          onChange={(event) => setScope(event.currentTarget.value as Key["scope"])}
          data={SCOPES.map((value) => ({ value, label: text(`scope.${value}`) }))}
        />
        {scope === "cell" && (
          <TextInput label={text("head.machine")} value={machine} onChange={(event) => setMachine(event.currentTarget.value)} />
        )}
        <TextInput
          label={text("settings.key.days")}
          inputMode="numeric"
          value={days}
          onChange={(event) => setDays(event.currentTarget.value)}
        />
      </div>
      <Refused problem={making.error} />
      <Act
        label={text("settings.key.make")}
        busy={making.isPending}
        why={empty || wrong}
        onClick={() => making.mutate({ path: "keys", body }, { onSuccess: () => setName("") })}
      />
      {making.isSuccess && <Once made={making.data} />}
    </div>
  );
}

/** The key itself; a request that was repeated is not answered with it. */
function Once({ made }: { made: Shape<"MadeKey"> | undefined }) {
  const text = useText();
  if (!made) return <p role="alert">{text("settings.key.lost")}</p>;
  return (
    <TextInput
      label={text("settings.key.once")}
      value={made.key}
      readOnly
      onFocus={(event) => event.currentTarget.select()}
    />
  );
}
