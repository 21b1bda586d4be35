import { Textarea } from "@mantine/core";
import { useState } from "react";

import { useChange, useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { Curves } from "../show/Curves";
import { useLengths } from "../show/lengths";
import { Picture } from "../show/Picture";
import { Act, Age, Head, Length, Refused, Rows, Section, Shown, SizeDeviation, State, To, useWhyNot } from "../show/parts";
import { useText } from "../text/text";

type Proposal = Shape<"ProposalView">;

/** All proposals, or the one at this address with what it does and its decision. */
export default function Proposals({ id }: { id: string }) {
  return id ? <One id={id} /> : <All />;
}

function All() {
  const text = useText();
  const found = useShown<{ items: Proposal[] }>("proposals");
  return (
    <>
      <Head title={text("page.proposals")} />
      <Section title={text("page.proposals")}>
        <Shown found={found}>
          {({ items }) => (
            <Rows
              label={text("page.proposals")}
              none={text("proposal.none")}
              head={(["said", "part_type", "state", "since", "by"] as const).map((one) => text(`head.${one}`))}
              rows={items.map((one) => ({
                key: one.id,
                cells: [
                  <To href={`/proposals/${encodeURIComponent(one.id)}`}>
                    {one.changes}: {one.effects.map((effect) => effect.characteristic).join(", ")}
                  </To>,
                  one.part_type,
                  <State kind="proposal" name={one.state} />,
                  <Age at={one.made_at} />,
                  one.made_by,
                ],
              }))}
            />
          )}
        </Shown>
      </Section>
    </>
  );
}

function One({ id }: { id: string }) {
  const text = useText();
  const { name, signed, plain } = useLengths();
  const known = (axis: string, u: number | null) =>
    u === null ? text("proposal.undetermined", { axis }) : `${axis} ± ${plain("mm", u)} ${name("mm")}`;
  const found = useShown<Proposal>(`proposals/${encodeURIComponent(id)}`);
  return (
    <>
      <Head title={found.data ? `${found.data.changes}, ${found.data.part_type}` : text("page.proposals")}>
        {found.data && <State kind="proposal" name={found.data.state} />}
      </Head>
      <Shown found={found}>
        {(one) => (
          <>
            <p className="soft">
              {one.made_by} <Age at={one.made_at} /> {one.why}
              {one.tool && ` · ${one.tool}: X ${signed("mm", one.dx_mm)} ${name("mm")} (${text("proposal.radius")}), Z ${signed("mm", one.dz_mm)} ${name("mm")}`}
              {one.tool && one.u_stated && ` (${known("X", one.dx_u_mm)}, ${known("Z", one.dz_u_mm)}; 95 %)`}
            </p>
            <Section title={text("proposal.effects")}>
              <figure className="curve">
                <Picture path={`proposals/${encodeURIComponent(one.id)}/picture`} said={text("proposal.picture")} />
                <figcaption className="soft">{text("proposal.key")}</figcaption>
              </figure>
              <Effects one={one} />
            </Section>
            {one.state === "open" ? (
              <Decide one={one} />
            ) : (
              one.decided_by && (
                <p className="soft">
                  {one.decided_by} <Age at={one.decided_at} /> {one.decided_why}
                </p>
              )
            )}
            {one.corrections.map((made) => (
              <Curves key={made} correction={made} title={text("proposal.last", { serial: one.last_serial })} />
            ))}
          </>
        )}
      </Shown>
    </>
  );
}

function Effects({ one }: { one: Proposal }) {
  const text = useText();
  const { signed } = useLengths();
  const heads = ["characteristic", "change", "before", "after", "u"] as const;
  return (
    <Rows
      label={text("proposal.effects")}
      none=""
      head={heads.map((head) => text(`head.${head}`))}
      rows={one.effects.map((effect) => ({
        key: effect.characteristic,
        cells: [
          effect.characteristic,
          <span className="number">{signed("um", effect.size_change_um)}</span>,
          <SizeDeviation um={effect.error_before_um} />,
          <SizeDeviation um={effect.error_after_um} />,
          <Length of="um" value={effect.standard_u_um} />,
        ],
      }))}
    />
  );
}

function Decide({ one }: { one: Proposal }) {
  const text = useText();
  const whyNot = useWhyNot();
  const [reason, write] = useState("");
  const change = useChange();
  const missing = whyNot("engineer") || (reason.trim() ? "" : text("act.why.missing"));

  function send(what: "accept" | "reject") {
    const path = `proposals/${encodeURIComponent(one.id)}/${what}`;
    change.mutate({ path, etag: one.etag, body: { why: reason.trim() } });
  }
  return (
    <Section title={text("action.review")}>
      <div className="fields">
        <Textarea
          label={text("act.why")}
          rows={2}
          maxLength={2000}
          value={reason}
          onChange={(event) => write(event.currentTarget.value)}
        />
        <Refused problem={change.error} />
        <div className="acts">
          <Act
            label={text("proposal.accept")}
            busy={change.isPending}
            why={one.refusal || missing}
            onClick={() => send("accept")}
          />
          <Act
            danger
            label={text("proposal.reject")}
            busy={change.isPending}
            why={missing}
            onClick={() => send("reject")}
          />
        </div>
      </div>
    </Section>
  );
}
