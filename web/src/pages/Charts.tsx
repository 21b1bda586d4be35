import { NativeSelect } from "@mantine/core";
import { useState } from "react";

import { useShown } from "../api/asking";
import { piece, type Shape } from "../api/client";
import { Chart } from "../show/chart/Chart";
import type { Plot } from "../show/chart/plot";
import { number } from "../show/format";
import { useLengths, useReader } from "../show/lengths";
import { Head, Rows, Section, Shown, To } from "../show/parts";
import { useName, useText } from "../text/text";
import { seriesAt } from "./SeriesPage";

type Charts = Shape<"ChartsShape">;
type Charted = Shape<"CharacteristicChartShape">;
type Segment = Shape<"SegmentShape">;
const RULES = { one: "1", four: "1 2 3 4", all: "1 2 3 4 5 6 7 8" } as const;

/** Control charts of one characteristic: alarms with what may explain them, and capability. */
export default function ChartsPage({ id, of }: { id: string; of: string }) {
  const text = useText();
  const [what, chart] = useState("value");
  const [rules, judge] = useState<keyof typeof RULES>("one");
  const [each, begin] = useState("false");
  const asked = RULES[rules].split(" ").map((one) => `&rules=${one}`).join("");
  const reader = useReader();
  const found = useShown<Charts>(
    `charts/${piece(of)}?characteristic=${piece(id)}&what=${what}&each_setting=${each}${asked}&${reader}`,
  );
  return (
    <>
      <Head title={`${text("chart.title")}: ${id}, ${of}`}>
        <To href={seriesAt(of, id)}>{text("page.series")}</To>
      </Head>
      <Section title={text("chart.how")}>
        <div className="two">
          <Choice label={text("chart.what")} value={what} set={chart} of={["value", "residual"]} words="chart.what" />
          <Choice label={text("chart.rules")} value={rules} set={(one) => judge(one as keyof typeof RULES)} of={["one", "four", "all"]} words="chart.rules" />
          <Choice label={text("chart.each")} value={each} set={begin} of={["false", "true"]} words="chart.each" />
        </div>
      </Section>
      <Shown found={found}>
        {(shown) => (
          <>
            {shown.characteristics.map((one) => (
              <Whole key={one.characteristic} one={one} unit={shown.unit === "um" ? "um" : "σ"} />
            ))}
            <Findings findings={shown.findings} />
          </>
        )}
      </Shown>
    </>
  );
}

function Choice({ label, value, set, of, words }: { label: string; value: string; set: (to: string) => void; of: string[]; words: string }) {
  const word = useName();
  return (
    <NativeSelect
      label={label}
      value={value}
      onChange={(event) => set(event.currentTarget.value)}
      data={of.map((one) => ({ value: one, label: word(words, one) }))}
    />
  );
}

function Whole({ one, unit }: { one: Charted; unit: string }) {
  const text = useText();
  const word = useName();
  const names = [...new Set(one.segments.flatMap((segment) => segment.charts.map((chart) => chart.name)))];
  return (
    <>
      <Section title={text("chart.alarms")}>
        <Alarms one={one} unit={unit} />
      </Section>
      {one.capability && (
        <Section title={text("chart.capability")}>
          <Capability found={one.capability} />
        </Section>
      )}
      {names.map((name) => (
        <Section key={name} title={word("chart.name", name)}>
          <Picture one={one} name={name} unit={unit} />
        </Section>
      ))}
      {one.remarks.length > 0 && (
        <Section title={text("head.notes")}>
          <ul className="remarks">
            {one.remarks.map((remark) => (
              <li key={remark}>{remark}</li>
            ))}
          </ul>
        </Section>
      )}
    </>
  );
}

/** One chart of all segments, each with its own middle line and limits. */
function Picture({ one, name, unit }: { one: Charted; name: string; unit: string }) {
  const text = useText();
  const word = useName();
  const { name: named, signed } = useLengths();
  const of = (take: (segment: Segment, k: number) => number | null | undefined) =>
    one.parts.map((_, k) => {
      const segment = one.segments.find(({ first, stop }) => first <= k && k < stop);
      return (segment && take(segment, k)) ?? null;
    });
  const chart = (segment: Segment) => segment.charts.find((each) => each.name === name);
  const plotted = of((segment, k) => chart(segment)?.plotted[k - segment.first]);
  const serials = new Map(one.parts.map((part, k) => [part.serial, k]));
  const alarms = one.alarms.flatMap((episode) => episode.alarms.filter((alarm) => alarm.chart === name));
  const plot: Plot = {
    x: one.parts.map((_, k) => k),
    lines: [
      { name: text("chart.centre"), colour: "soft", dash: true, values: of((segment) => chart(segment)?.centre) },
      { name: text("series.upper"), colour: "bad", dash: true, values: of((segment, k) => chart(segment)?.high[k - segment.first]) },
      { name: text("series.lower"), colour: "bad", dash: true, values: of((segment, k) => chart(segment)?.low[k - segment.first]) },
      { name: word("chart.name", name), colour: "after", dots: "full", values: plotted },
    ],
    marks: alarms.flatMap(({ serial }) => {
      const x = serials.get(serial);
      const y = x === undefined ? null : plotted[x];
      return x === undefined || y == null ? [] : [{ x, y, colour: "bad", shape: "alarm" } as const];
    }),
    uprights: one.parts.flatMap((part, k) => (part.tool_set ? [{ at: k - 0.5, name: text("series.tool") }] : [])),
    xName: text("series.part"),
    yName: unit === "um" ? "" : unit,
    ...(unit === "um" ? { yIn: unit } : {}),
    xText: (at) => one.parts[at]?.serial ?? "",
    whole: true,
  };
  return (
    <Chart
      plot={plot}
      label={text("chart.picture", { chart: word("chart.name", name), name: one.characteristic, parts: one.parts.length })}
      at={(k) => `${one.parts[k]?.serial}: ${signed(unit, plotted[k], 2)} ${named(unit)}`}
      keys={[
        { name: word("chart.name", name), colour: "after", sign: "●" },
        { name: text("chart.centre"), colour: "soft", sign: "┄" },
        { name: text("chart.limits"), colour: "bad", sign: "┄" },
        { name: text("chart.alarm"), colour: "bad", sign: "△" },
      ]}
    />
  );
}

function Alarms({ one, unit }: { one: Charted; unit: string }) {
  const text = useText();
  const word = useName();
  const { name, plain, signed } = useLengths();
  return (
    <Rows
      label={text("chart.alarms")}
      none={text("chart.alarms.none")}
      head={(["parts", "since", "what", "causes"] as const).map((head) => text(head === "causes" ? "chart.causes" : head === "since" ? "chart.since" : `head.${head}`))}
      rows={one.alarms.map((episode) => ({
        key: episode.first,
        look: "bad",
        cells: [
          episode.first === episode.last ? episode.first : `${episode.first} … ${episode.last}`,
          episode.since,
          <ul className="remarks">
            {episode.alarms.map((alarm, k) => (
              <li key={k}>{`${alarm.serial}, ${word("chart.name", alarm.chart)}: ${alarm.meaning}`}</li>
            ))}
          </ul>,
          <ul className="remarks">
            {episode.causes.map((cause, k) => (
              <li key={k}>{`${number(100 * cause.probability, 0)} % ${cause.words} (${signed(unit, cause.size, 1)} ± ${plain(unit, cause.size_u, 1)} ${name(unit)})`}</li>
            ))}
            <li>{`${number(100 * episode.unknown, 0)} % ${text("chart.unknown")}`}</li>
            <li>{`${number(100 * episode.chance, 0)} % ${text("chart.chance")}`}</li>
          </ul>,
        ],
      }))}
    />
  );
}

/** Of residuals there is none: it is of errors in µm. */
function Capability({ found }: { found: Shape<"CapabilityShape"> }) {
  const text = useText();
  const { plain, signed } = useLengths();
  return (
    <>
      <p>
        {text("chart.spread", {
          count: found.count,
          mean: signed("um", found.mean),
          sigma: plain("um", found.sigma),
          short: plain("um", found.short_sigma),
        })}
      </p>
      <Rows
        label={text("chart.capability")}
        none=""
        head={[text("chart.index"), text("head.values"), text("chart.interval")]}
        rows={found.indices.map((one) => ({
          key: one.name,
          cells: [
            one.name,
            <span className="number">{number(one.value, 2)}</span>,
            <span className="number">{`${number(one.low, 2)} … ${number(one.high, 2)}`}</span>,
          ],
        }))}
      />
    </>
  );
}

/** What is odd about what was read. */
export function Findings({ findings }: { findings: Shape<"FindingShape">[] }) {
  const text = useText();
  if (findings.length === 0) return null;
  return (
    <Section title={text("diagnosis.findings")}>
      <ul className="remarks">
        {findings.map((one, k) => (
          <li key={k}>
            <code>{one.code}</code> {one.message} <span className="soft">{one.hint}</span>
          </li>
        ))}
      </ul>
    </Section>
  );
}
