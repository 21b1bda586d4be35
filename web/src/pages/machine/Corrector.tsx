import { useTrace, type Stretch } from "../../live/trace";
import { useContact } from "../../live/contact";
import { Chart } from "../../show/chart/Chart";
import type { Colour, Line, Plot } from "../../show/chart/plot";
import { number } from "../../show/format";
import type { Given } from "../../show/length";
import { useLengths } from "../../show/lengths";
import { Age, Section } from "../../show/parts";
import { useName, useText } from "../../text/text";

const SILENT_MS = 5000;
const CAUSES = [
  ["correction", "after"],
  ["model", "taken"],
  ["table", "warm"],
] as const;
const COLOURS: Colour[] = ["left-on", "taken", "warm", "good", "after", "soft"];
const SAID = ["state", "fault", "line", "age", "write", "thread", "periods"] as const;

/** The corrector as it works: command, correction by cause, and signals, of the last minute. */
export function Corrector({ machine }: { machine: string }) {
  const text = useText();
  const trace = useTrace(machine);
  const { now } = useContact();
  const last = trace.at(-1);
  const stale = last !== undefined && now - Date.parse(last.at) > SILENT_MS;
  return (
    <Section title={text("machine.corrector")} side={last && <Age at={last.at} stale={stale} />}>
      {last ? (
        <div className={stale ? "stale" : ""}>
          <Words last={last} />
          <Pictures trace={trace} last={last} />
        </div>
      ) : (
        <p className="none">{text("machine.corrector.none")}</p>
      )}
    </Section>
  );
}

function Words({ last }: { last: Stretch }) {
  const text = useText();
  return (
    <dl className="facts">
      {SAID.filter((name) => last.said[name] !== undefined).map((name) => (
        <div key={name} className="pair">
          <dt>{text(`machine.said.${name}`)}</dt>
          <dd className={name === "state" && last.alarm ? "why" : ""}>{last.said[name]}</dd>
        </div>
      ))}
    </dl>
  );
}

function Pictures({ trace, last }: { trace: Stretch[]; last: Stretch }) {
  const text = useText();
  const word = useName();
  const axes = [...last.axes];
  const command = axes.map((axis, k) => lineOf(trace, `command_${axis}_mm`, axis.toUpperCase(), COLOURS[k % COLOURS.length] ?? "soft"));
  const ofAxis = (axis: string) =>
    CAUSES.map(([cause, colour]) => lineOf(trace, `${cause}_${axis}_um`, word("machine.cause", cause), colour));
  const signals = last.signals.map((name, k) => lineOf(trace, name, name, COLOURS[k % COLOURS.length] ?? "soft"));
  return (
    <>
      {axes.map((axis) => (
        <Picture key={axis} trace={trace} lines={ofAxis(axis)} name={text("machine.correction", { axis: axis.toUpperCase() })} of="um" />
      ))}
      <Picture trace={trace} lines={command} name={text("machine.command")} of="mm" digits={3} />
      {signals.length > 0 && <Picture trace={trace} lines={signals} name={text("machine.signals")} digits={2} />}
    </>
  );
}

interface Drawn {
  trace: Stretch[];
  lines: Line[];
  name: string;
  /** What the values are lengths of; signals are none. */
  of?: Given;
  digits?: number;
}

function Picture({ trace, lines, name, of, digits = 2 }: Drawn) {
  const text = useText();
  const { name: unit, plain } = useLengths();
  const plot: Plot = {
    x: trace.map((one) => (one.from + one.to) / 2),
    lines,
    shaded: trace.filter((one) => one.alarm).map((one) => [one.from, one.to]),
    xName: text("machine.time"),
    yName: name,
    ...(of ? { yIn: of } : {}),
  };
  const said = (k: number) => lines.map((one) => `${one.name} ${plain(of ?? "", one.values[k], digits)} ${unit(of ?? "")}`.trim()).join(", ");
  return (
    <Chart
      plot={plot}
      label={text("machine.picture", { name: `${name} ${unit(of ?? "")}`.trim() })}
      at={(k) => `${number(plot.x[k], 1)} s: ${said(k)}`}
      keys={lines.map((one) => ({ name: one.name, colour: one.colour, sign: "━" }))}
    />
  );
}

/** The middle of the least and largest value of every stretch, with the band between them. */
function lineOf(trace: Stretch[], key: string, name: string, colour: Colour): Line {
  const ends = trace.map(({ low, high }) => [low[key] ?? null, high[key] ?? null] as const);
  return {
    name,
    colour,
    values: ends.map(([low, high]) => (low === null || high === null ? null : (low + high) / 2)),
    band: ends.map(([low, high]) => (low === null || high === null ? null : (high - low) / 2)),
  };
}
