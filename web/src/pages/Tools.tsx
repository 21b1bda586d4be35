import { useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { Age, Head, Length, Rows, Section, Shown, To } from "../show/parts";
import { useText } from "../text/text";

const HEADS = ["tool", "edge", "nose", "set", "parts"] as const;

/** The edges of all tools; each leads to what it remembers. */
export default function Tools() {
  const text = useText();
  const found = useShown<{ items: Shape<"ToolRow">[] }>("tools");
  return (
    <>
      <Head title={text("page.tools")} />
      <Section title={text("page.tools")}>
        <Shown found={found}>
          {({ items }) => (
            <Rows
              label={text("page.tools")}
              none={text("tool.none")}
              head={HEADS.map((one) => text(`head.${one}`))}
              rows={items.map((one) => ({
                key: one.id,
                cells: [
                  <To href={`/tools/${one.id}`}>{one.tool}</To>,
                  one.edge,
                  <Length of="mm" value={one.nose_radius_mm} digits={3} />,
                  <Age at={one.set_at} />,
                  one.parts,
                ],
              }))}
            />
          )}
        </Shown>
      </Section>
    </>
  );
}
