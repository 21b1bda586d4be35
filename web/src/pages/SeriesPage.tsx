import { NativeSelect } from "@mantine/core";
import { useState } from "react";

import { useShown } from "../api/asking";
import { piece, type Shape } from "../api/client";
import { Chart } from "../show/chart/Chart";
import type { Plot } from "../show/chart/plot";
import { number } from "../show/format";
import { type Lengths, useLengths, useReader } from "../show/lengths";
import { Age, Head, Rows, Section, Shown, SizeDeviation, To } from "../show/parts";
import { useText } from "../text/text";

type View = Shape<"SeriesView">;
type Point = Shape<"SeriesPoint">;
const COUNTS = [50, 200, 1000];
const LISTED = 50;
const HEADS = ["serial", "at", "deviation", "without", "expected", "tool", "flags"] as const;

/** One characteristic over the parts: as made, as it had been without correction, what was expected, what follows. */
export default function SeriesPage({ id, of }: { id: string; of: string }) {
  const text = useText();
  const found = useShown<View>(`series/${piece(of)}/${piece(id)}?${useReader()}`);
  return (
    <>
      <Head title={`${id}, ${of}`}>
        <To href={`/charts/${piece(of)}/${piece(id)}`}>{text("chart.title")}</To>
        <To href={`/diagnosis/${piece(of)}`}>{text("page.diagnosis")}</To>
        {found.data?.proposals.map((one) => (
          <To key={one} href={`/proposals/${piece(one)}`}>
            {text("series.open")}
          </To>
        ))}
      </Head>
      <Shown found={found}>{(view) => <Whole view={view} />}</Shown>
    </>
  );
}

function Whole({ view }: { view: View }) {
  const text = useText();
  const every = view.points.length;
  const [count, choose] = useState(COUNTS[0] ?? every);
  const points = view.points.slice(-count);
  const choices = [...COUNTS.filter((one) => one < every), every];
  return (
    <>
      <Section title={text("series.parts")}>
        {choices.length > 1 && (
          <NativeSelect
            label={text("series.shown")}
            value={Math.min(count, every)}
            onChange={(event) => choose(Number(event.currentTarget.value))}
            data={choices.map((one) => ({
              value: String(one),
              label: text(one === every ? "series.every" : "series.latest", { count: one }),
            }))}
          />
        )}
        <Picture view={view} points={points} />
        <Facts view={view} />
      </Section>
      <Section title={text("series.weight")}>
        <p>{text("series.weight.now", { weight: number(view.weight, 2) })}</p>
        <ul className="remarks">
          {view.moves.toReversed().map((one) => (
            <li key={one.serial}>
              {text("series.weight.move", { ...one, before: number(one.before, 2), after: number(one.after, 2) })}
            </li>
          ))}
        </ul>
      </Section>
      <Section title={text("series.latest", { count: Math.min(every, LISTED) })}>
        <Listed points={view.points.slice(-LISTED).toReversed()} />
      </Section>
    </>
  );
}

function Picture({ view, points }: { view: View; points: Point[] }) {
  const text = useText();
  const flags = useFlags();
  const lengths = useLengths();
  const plot: Plot = {
    x: points.map((_, k) => k),
    lines: [
      {
        name: text("series.key.expected"),
        colour: "soft",
        dash: true,
        values: points.map((one) => one.expected_um),
        band: points.map((one) => one.band_um),
      },
      {
        name: text("series.key.before"),
        colour: "warm",
        line: false,
        dots: "open",
        values: points.map((one) => (one.without_correction_um === one.deviation_um ? null : one.without_correction_um)),
      },
      { name: text("series.key.after"), colour: "after", dots: "full", values: points.map((one) => one.deviation_um) },
    ],
    marks: points.flatMap((one, x) => (one.alarm ? [{ x, y: one.deviation_um, colour: "bad", shape: "alarm" } as const] : [])),
    levels: [
      ...(view.upper_um === null ? [] : [{ at: view.upper_um, name: text("series.upper") }]),
      ...(view.lower_um === null ? [] : [{ at: view.lower_um, name: text("series.lower") }]),
    ],
    uprights: points.flatMap((one, k) => (one.tool_changed ? [{ at: k - 0.5, name: text("series.tool") }] : [])),
    xName: text("series.part"),
    yName: text("series.deviation"),
    yIn: "um",
    xText: (at) => points[at]?.serial ?? "",
    whole: true,
  };
  const said = (k: number) => {
    const one = points[k];
    if (!one) return "";
    const band = one.expected_um === null ? "" : `, ${expected(one, text, lengths)}`;
    return `${one.serial}: ${lengths.signed("um", one.deviation_um)} ${lengths.name("um")}${band} ${flags(one)}`;
  };
  return (
    <Chart
      plot={plot}
      at={said}
      label={text("series.picture", { name: view.row.characteristic, parts: points.length })}
      keys={[
        { name: text("series.key.after"), colour: "after", sign: "●" },
        { name: text("series.key.before"), colour: "warm", sign: "○" },
        { name: text("series.key.expected"), colour: "soft", sign: "┄" },
        { name: text("series.key.limit"), colour: "bad", sign: "--" },
        { name: text("series.key.alarm"), colour: "bad", sign: "△" },
      ]}
    />
  );
}

function Facts({ view }: { view: View }) {
  const text = useText();
  const { name, plain, signed } = useLengths();
  return (
    <dl className="facts">
      <dt>{text("head.nominal")}</dt>
      <dd className="number">
        {plain(view.unit, view.nominal)} {name(view.unit)}
      </dd>
      <dt>{text("head.limits")}</dt>
      <dd className="number">
        {signed("um", view.lower_um)} … {signed("um", view.upper_um)} {name("um")}
      </dd>
      <dt>Ppk</dt>
      <dd>{view.ppk === null ? text("series.ppk.none") : text("series.ppk", { ppk: number(view.ppk, 2), lower: number(view.ppk_lower, 2) })}</dd>
      <dt>{text("head.next")}</dt>
      <dd>
        <SizeDeviation um={view.row.expected_um} />
      </dd>
    </dl>
  );
}

function Listed({ points }: { points: Point[] }) {
  const text = useText();
  const { plain, signed } = useLengths();
  const flags = useFlags();
  return (
    <Rows
      label={text("series.parts")}
      none=""
      head={HEADS.map((one) => text(`head.${one}`))}
      rows={points.map((one) => ({
        key: one.serial,
        look: one.alarm ? "bad" : one.quarantined ? "stale" : "",
        cells: [
          one.serial,
          <Age at={one.at} />,
          <SizeDeviation um={one.deviation_um} />,
          <SizeDeviation um={one.without_correction_um} />,
          one.expected_um === null ? "" : <span className="number">{`${signed("um", one.expected_um)} ± ${plain("um", one.band_um)}`}</span>,
          one.edge === null ? one.tool : <To href={`/tools/${one.edge}`}>{one.tool}</To>,
          flags(one),
        ],
      }))}
    />
  );
}

/** What was flagged of a part, in words. */
function useFlags() {
  const text = useText();
  return (one: Point) =>
    [
      one.alarm && text("series.alarm"),
      one.tool_changed && text("series.tool"),
      one.quarantined && text("series.quarantined"),
    ]
      .filter(Boolean)
      .join(", ");
}

function expected(one: Point, text: ReturnType<typeof useText>, { plain, signed }: Lengths): string {
  return text("series.expected", { expected: signed("um", one.expected_um), band: plain("um", one.band_um) });
}

const LIST_HEADS = ["characteristic", "part_type", "parts", "serial", "deviation", "next", "flags"] as const;

/** The address of a series. */
export const seriesAt = (part_type: string, characteristic: string) => `/series/${piece(part_type)}/${piece(characteristic)}`;

/** The series of all part types, each with its last part. */
export function Series() {
  const text = useText();
  const found = useShown<{ items: Shape<"SeriesRow">[] }>("series");
  return (
    <>
      <Head title={text("page.series")} />
      <Section title={text("page.series")}>
        <Shown found={found}>
          {({ items }) => (
            <Rows
              label={text("page.series")}
              none={text("series.none")}
              head={LIST_HEADS.map((one) => text(`head.${one}`))}
              rows={items.map((one) => ({
                key: `${one.part_type} ${one.revision} ${one.characteristic}`,
                look: one.alarm ? "bad" : "",
                cells: [
                  <To href={seriesAt(one.part_type, one.characteristic)}>{one.characteristic}</To>,
                  `${one.part_type} ${one.revision}`,
                  one.parts,
                  one.last_serial,
                  <SizeDeviation um={one.last_deviation_um} />,
                  <SizeDeviation um={one.expected_um} />,
                  one.alarm && `${text("series.alarm")}: ${one.alarm}`,
                ],
              }))}
            />
          )}
        </Shown>
      </Section>
    </>
  );
}
