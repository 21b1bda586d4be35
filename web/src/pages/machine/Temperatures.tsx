import type { Shape } from "../../api/client";
import { Chart } from "../../show/chart/Chart";
import type { Colour, Plot } from "../../show/chart/plot";
import { moment, number } from "../../show/format";
import { Age, Rows, Section } from "../../show/parts";
import { useText } from "../../text/text";

type Series = Shape<"TemperatureView">;
const COLOURS: Colour[] = ["after", "left-on", "taken", "warm", "good", "soft"];

/** What the sensors said last, and over the latest hours. */
export function Temperatures({ machine }: { machine: Shape<"MachineView"> }) {
  const text = useText();
  const series = machine.temperatures;
  return (
    <Section title={text("head.temperatures")}>
      <Rows
        label={text("head.temperatures")}
        none={text("machine.temperatures.none")}
        head={[text("machine.sensor"), "°C", text("head.at")]}
        rows={series.map((one) => ({
          key: one.signal,
          look: one.stale ? "stale" : "",
          cells: [one.signal, <span className="number">{number(one.celsius.at(-1), 2)}</span>, <Age at={one.at.at(-1)} stale={one.stale} />],
        }))}
      />
      {series.some((one) => one.at.length > 1) && <Picture series={series} />}
    </Section>
  );
}

function Picture({ series }: { series: Series[] }) {
  const text = useText();
  const moments = [...new Set(series.flatMap((one) => one.at))].sort((a, b) => Date.parse(a) - Date.parse(b));
  const said = series.map((one) => new Map(one.at.map((at, k) => [at, one.celsius[k] ?? null])));
  const plot: Plot = {
    x: moments.map((at) => Date.parse(at) / 1000),
    lines: series.map((one, k) => ({
      name: one.signal,
      colour: COLOURS[k % COLOURS.length] ?? "soft",
      values: moments.map((at) => said[k]?.get(at) ?? null),
      joined: true,
    })),
    xName: text("head.at"),
    yName: "°C",
    time: true,
  };
  return (
    <Chart
      plot={plot}
      label={text("machine.temperatures.picture", { count: series.length })}
      at={(k) =>
        `${moment(moments[k])}: ${series.map((one, n) => `${one.signal} ${number(said[n]?.get(moments[k] ?? ""), 2)} °C`).join(", ")}`
      }
      keys={plot.lines.map((one) => ({ name: one.name, colour: one.colour, sign: "━" }))}
    />
  );
}
