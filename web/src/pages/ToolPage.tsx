import { NativeSelect } from "@mantine/core";
import { useState } from "react";

import { useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { Chart } from "../show/chart/Chart";
import type { Plot } from "../show/chart/plot";
import { number } from "../show/format";
import { useLengths, useReader } from "../show/lengths";
import { Age, Head, Length, Rows, Section, Shown, To } from "../show/parts";
import { useName, useText } from "../text/text";

type Memory = Shape<"ToolMemory">;

/** What one edge remembers: its error over the contact angle, and what a next part would need. */
export default function ToolPage({ id }: { id: string }) {
  const text = useText();
  const found = useShown<Memory>(`tools/${encodeURIComponent(id)}/memory?${useReader()}`);
  return (
    <>
      <Head title={found.data ? `${found.data.tool.tool} ${found.data.tool.edge}` : text("page.tools")}>
        {found.data && <Age at={found.data.tool.set_at} />}
      </Head>
      <Shown found={found}>
        {(memory) => (
          <>
            <Section title={text("tool.memory")}>
              {memory.curves.length === 0 ? <p className="none">{text("tool.memory.none")}</p> : <Curves memory={memory} />}
            </Section>
            {memory.next_parts.length > 0 && (
              <Section title={text("tool.next")}>
                <Next memory={memory} />
              </Section>
            )}
            <Section title={text("tool.events")}>
              <Events memory={memory} />
            </Section>
          </>
        )}
      </Shown>
    </>
  );
}

function Curves({ memory }: { memory: Memory }) {
  const text = useText();
  const { name: unit, plain, signed } = useLengths();
  const [chosen, choose] = useState(memory.curves.at(-1)?.part_type ?? "");
  const curve = memory.curves.find((one) => one.part_type === chosen) ?? memory.curves[0];
  if (!curve) return null;
  const name = (type: string) => (type ? text("tool.of", { name: type }) : text("tool.form"));
  const angles = memory.contact_angle_deg;
  const points = memory.points.filter((one) => (curve.part_type ? one.finish && one.part_type === curve.part_type : !one.finish));
  const plot: Plot = {
    x: angles,
    lines: [{ name: name(curve.part_type), colour: "after", values: curve.error_um, band: curve.band_um }],
    marks: points.map((one) => ({ x: one.contact_angle_deg, y: one.error_um, colour: "warm", shape: "open" })),
    unseen: unseen(angles, memory.seen),
    xName: text("tool.angle"),
    yName: text("tool.error"),
    yIn: "um",
  };
  const [x, z] = memory.setting_um;
  const [ux, uz] = memory.setting_band_um;
  return (
    <>
      <p>
        {text("tool.parts", { parts: memory.parts, inspected: memory.inspected })}{" "}
        {text("tool.setting", { x: signed("um", x), ux: plain("um", ux), z: signed("um", z), uz: plain("um", uz) })}
      </p>
      <NativeSelect
        label={text("tool.curve")}
        value={curve.part_type}
        onChange={(event) => choose(event.currentTarget.value)}
        data={memory.curves.map((one) => ({ value: one.part_type, label: name(one.part_type) }))}
      />
      <Chart
        plot={plot}
        at={(k) => `${number(angles[k], 0)}°: ${signed("um", curve.error_um[k])} ± ${plain("um", curve.band_um[k])} ${unit("um")}`}
        label={text("tool.picture", {
          curve: name(curve.part_type),
          low: number(angles[0], 0),
          high: number(angles.at(-1), 0),
        })}
        keys={[
          { name: `${name(curve.part_type)}, ${text("tool.key.band")}`, colour: "after", sign: "━" },
          { name: text("tool.key.points"), colour: "warm", sign: "○" },
          { name: text("tool.key.unseen"), colour: "soft", sign: "▒" },
        ]}
      />
    </>
  );
}

/** Stretches of angles that no part has shown. */
function unseen(angles: number[], seen: boolean[]): [number, number][] {
  const found: [number, number][] = [];
  angles.forEach((angle, k) => {
    if (seen[k]) return;
    const last = found.at(-1);
    if (last && k > 0 && !seen[k - 1]) last[1] = angle;
    else found.push([angle, angle]);
  });
  return found;
}

function Next({ memory }: { memory: Memory }) {
  const text = useText();
  const heads = ["part_type", "enough", "left", "notes"] as const;
  return (
    <Rows
      label={text("tool.next")}
      none=""
      head={heads.map((one) => text(`head.${one}`))}
      rows={memory.next_parts.map((one) => ({
        key: one.part_type,
        cells: [
          one.part_type,
          text("tool.enough", { touches: one.touches, of: one.of }),
          <Length of="um" value={one.left_um} />,
          one.refusal || one.notes.join(" "),
        ],
      }))}
    />
  );
}

function Events({ memory }: { memory: Memory }) {
  const text = useText();
  const { named } = useLengths();
  const word = useName();
  return (
    <Rows
      label={text("tool.events")}
      none={text("part.events.none")}
      head={(["at", "what", "values", "by"] as const).map((one) => text(`head.${one}`))}
      rows={memory.events.toReversed().map((one, k) => ({
        key: k,
        cells: [
          <Age at={one.at} />,
          word("edge", one.kind),
          Object.entries(one.values)
            .map((one) => named(...one).join(" "))
            .join(", "),
          one.by,
        ],
      }))}
    />
  );
}

const HEADS = ["tool", "edge", "nose", "set", "parts"] as const;

/** The edges of all tools; each leads to what it remembers. */
export function Tools() {
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
