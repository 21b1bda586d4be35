import { useLocation } from "wouter";

import { usePages } from "../api/asking";
import type { Shape } from "../api/client";
import { Act, Age, Head, More, Rows, Section, Shown, State, To, useWhyNot } from "../show/parts";
import { useText } from "../text/text";

const HEAD = ["order", "part_type", "machine", "parts", "finished", "held", "state", "made", "by"] as const;

/** All orders, the latest first. */
export default function Orders() {
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
