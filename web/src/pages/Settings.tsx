import { usePages } from "../api/asking";
import type { Shape } from "../api/client";
import { hash } from "../show/format";
import { Age, Head, More, Outcome, Rows, Section, Shown } from "../show/parts";
import { may, useUser } from "../show/roles";
import { useName, useText } from "../text/text";
import { Accounts } from "./settings/Accounts";
import { Keys } from "./settings/Keys";
import { Links } from "./settings/Links";
import { Mine } from "./settings/Mine";

/** One's own account; for administrators the accounts and keys of all; links to controls, and what went over them. */
export default function Settings() {
  const text = useText();
  const { role } = useUser();
  const admin = may(role, "admin");
  return (
    <>
      <Head title={text("page.settings")} />
      <Mine />
      {admin && <Accounts />}
      {admin && <Keys />}
      {may(role, "engineer") && <Links />}
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
                <Outcome said={one.outcome} />,
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
