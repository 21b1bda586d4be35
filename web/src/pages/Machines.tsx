import { useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { Head, Section, Shown } from "../show/parts";
import { useText } from "../text/text";
import { Machines as MachineRows } from "./Today";

const EVERY_S = 2;

/** All machines as last heard; each leads to its own page. */
export default function Machines() {
  const text = useText();
  const found = useShown<{ items: Shape<"MachineNow">[] }>("machines", EVERY_S);
  return (
    <>
      <Head title={text("page.machines")} />
      <Section title={text("page.machines")}>
        <Shown found={found}>{({ items }) => <MachineRows machines={items} />}</Shown>
      </Section>
    </>
  );
}
