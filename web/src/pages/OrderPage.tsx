import { useLocation } from "wouter";

import { usePages, useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { hash, moment } from "../show/format";
import { Act, Age, Head, More, Rows, Section, Shown, State, To, useWhyNot } from "../show/parts";
import { useName, useText } from "../text/text";

type OrderView = Shape<"OrderView">;

/** One order: its route, and how far each part has come. */
export default function OrderPage({ id }: { id: string }) {
  const text = useText();
  const found = useShown<OrderView>(`orders/${encodeURIComponent(id)}`);
  return (
    <>
      <Head title={text("order.of", { id })}>
        {found.data && <State kind="state" name={found.data.row.state} />}
      </Head>
      <Shown found={found}>
        {(order) => (
          <>
            <About order={order} />
            <Section title={text("order.parts")}>
              <Parts order={order} />
            </Section>
            <Section title={text("order.route")}>
              <Route order={order} />
            </Section>
          </>
        )}
      </Shown>
    </>
  );
}

function About({ order: { row, armed_parts } }: { order: OrderView }) {
  const text = useText();
  return (
    <p className="soft">
      {row.part_type} · {row.machine} · {text("order.by", { by: row.made_by, at: moment(row.made_at) })}
      {armed_parts > 0 && <> · {text("order.armed", { parts: armed_parts })}</>}
    </p>
  );
}

function Parts({ order }: { order: OrderView }) {
  const text = useText();
  const word = useName();
  return (
    <Rows
      label={text("order.parts")}
      none={text("part.none")}
      head={(["part", "state", "steps", "held"] as const).map((one) => text(`head.${one}`))}
      rows={order.parts.map((one) => ({
        key: one.id,
        look: one.state === "held" ? "bad" : "",
        cells: [
          <To href={`/parts/${one.id}`}>{one.serial}</To>,
          <State kind="state" name={one.state} />,
          <span className="dots">
            {one.steps.map((state, k) => (
              <i
                key={k}
                className={DOT[state] ?? ""}
                role="img"
                aria-label={`${word("kind", order.blocks[k]?.kind)}: ${word("step", state)}`}
                title={`${word("kind", order.blocks[k]?.kind)}: ${word("step", state)}`}
              />
            ))}
          </span>,
          one.held_why,
        ],
      }))}
    />
  );
}

const DOT: Record<string, string> = {
  recorded: "good",
  unknown: "bad",
  failed: "bad",
  offered: "busy",
  sent: "busy",
  verified: "busy",
  started: "busy",
  ended: "busy",
};

function Route({ order }: { order: OrderView }) {
  const text = useText();
  const word = useName();
  return (
    <Rows
      label={text("order.route")}
      none=""
      head={(["step", "feature", "program", "hash"] as const).map((one) => text(`head.${one}`))}
      rows={order.blocks.map((one) => ({
        key: one.no,
        cells: [
          `${one.no} ${word("kind", one.kind)}`,
          one.feature,
          one.program,
          one.program_sha256 && <code>{hash(one.program_sha256)}</code>,
        ],
      }))}
    />
  );
}

const HEAD = ["order", "part_type", "machine", "parts", "finished", "held", "state", "made", "by"] as const;

/** All orders, the latest first. */
export function Orders() {
  const text = useText();
  const whyNot = useWhyNot();
  const [, go] = useLocation();
  const list = usePages<Shape<"OrderRow">>("orders");
  return (
    <>
      <Head title={text("page.orders")}>
        <Act label={text("order.plan")} why={whyNot("engineer")} onClick={() => go("/orders/new")} />
      </Head>
      <Section title={text("page.orders")}>
        <Shown found={list}>
          {(orders) => (
            <Rows
              label={text("page.orders")}
              none={text("order.none")}
              head={HEAD.map((one) => text(`head.${one}`))}
              rows={orders.map((one) => ({
                key: one.id,
                look: one.held > 0 ? "bad" : "",
                cells: [
                  <To href={`/orders/${encodeURIComponent(one.id)}`}>{one.id}</To>,
                  one.part_type,
                  one.machine,
                  one.quantity,
                  one.finished,
                  one.held,
                  <State kind="state" name={one.state} />,
                  <Age at={one.made_at} />,
                  one.made_by,
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
