import { Textarea } from "@mantine/core";
import { useState } from "react";

import { useChange } from "../../api/asking";
import type { Shape } from "../../api/client";
import { Act, Refused, Section, useWhyNot } from "../../show/parts";
import type { Role } from "../../show/roles";
import { useName, useText } from "../../text/text";

type Life = Shape<"PartLife">;
const BY_HAND = ["remove", "measure", "release"];
const VERDICTS = ["made", "not-made", "reject"] as const;

/** What a person may do to the part now: decide where it is held, else record a step done by hand, or hold it. */
export function Decide({ life }: { life: Life }) {
  const text = useText();
  const word = useName();
  const whyNot = useWhyNot();
  const [reason, write] = useState("");
  const change = useChange();
  const { part, etag, steps, events } = life;
  const next = steps.find((one) => one.state !== "recorded");
  if (!next || part.state === "rejected") return null;

  const order = `orders/${encodeURIComponent(part.order)}`;
  const held = part.state === "held";
  const gauged = next.kind === "correct" ? steps.findLast((one) => one.no < next.no) : undefined;
  const values = { no: next.no, kind: word("kind", next.kind) };
  const why = (role: Role) => whyNot(role) || (reason.trim() ? "" : text("act.why.missing"));

  function send(path: string, body: object) {
    change.mutate({ path, etag, body: { ...body, why: reason.trim() } }, { onSuccess: () => write("") });
  }
  return (
    <Section title={text(held ? "part.held" : "part.next", values)}>
      {held && (
        <p>
          {text("part.why")}: <strong>{events.findLast((one) => one.what === "held")?.values["why"]}</strong>
        </p>
      )}
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
          {held ? (
            <>
              {gauged?.kind === "probe" && (
                <Act
                  label={text("part.probe.again")}
                  busy={change.isPending}
                  why={why("operator")}
                  onClick={() => send(`${order}/decide`, { part: part.id, step: gauged.no, verdict: "not-made" })}
                />
              )}
              {VERDICTS.map((verdict) => (
                <Act
                  key={verdict}
                  label={text(`part.${verdict}`)}
                  danger={verdict === "reject"}
                  busy={change.isPending}
                  why={why("operator")}
                  onClick={() => send(`${order}/decide`, { part: part.id, step: next.no, verdict })}
                />
              ))}
            </>
          ) : (
            <>
              {BY_HAND.includes(next.kind) && (
                <Act
                  label={text("part.record", { kind: values.kind })}
                  busy={change.isPending}
                  why={why(next.kind === "release" ? "engineer" : "operator")}
                  onClick={() => send(`${order}/parts/${part.id}/record`, { step: next.no })}
                />
              )}
              <Act
                danger
                label={text("part.hold")}
                busy={change.isPending}
                why={why("operator")}
                onClick={() => send(`${order}/hold`, { part: part.id })}
              />
            </>
          )}
        </div>
      </div>
    </Section>
  );
}
