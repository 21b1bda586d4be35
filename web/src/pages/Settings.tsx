import { usePages } from "../api/asking";
import type { Shape } from "../api/client";
import { hash } from "../show/format";
import { Age, Head, More, Rows, Section, Shown, State } from "../show/parts";
import { may, useUser } from "../show/roles";
import { useName, useText } from "../text/text";
import { Accounts } from "./settings/Accounts";
import { Keys } from "./settings/Keys";
import { Mine } from "./settings/Mine";

/** One's own account; for administrators the accounts and keys of all; and what went to and came from controls. */
export default function Settings() {
  const text = useText();
  const admin = may(useUser().role, "admin");
  return (
    <>
      <Head title={text("page.settings")} />
      <Mine />
      {admin && <Accounts />}
      {admin && <Keys />}
      <Section title={text("settings.transfers")}>
        <Transfers />
      </Section>
    </>
  );
}

function Transfers() {
  const text = useText();
  const word = useName();
  const list = usePages<Shape<"TransferView">>("transfers");
  const heads = ["control", "at", "program", "direction", "outcome", "hash", "by"] as const;
  return (
    <>
      <Shown found={list}>
        {(transfers) => (
          <Rows
            label={text("settings.transfers")}
            none={text("settings.transfers.none")}
            head={heads.map((one) => text(`head.${one}`))}
            rows={transfers.map((one) => ({
              key: one.id,
              cells: [
                one.control,
                <Age at={one.at} />,
                one.program,
                word("direction", one.direction),
                <State kind="outcome" name={one.outcome} />,
                <code className="number">{hash(one.sent_sha256)}</code>,
                one.who,
              ],
            }))}
          />
        )}
      </Shown>
      <More list={list} />
    </>
  );
}
