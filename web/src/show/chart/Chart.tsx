import { Loader, useComputedColorScheme } from "@mantine/core";
import { useEffect, useMemo, useRef, useState } from "react";
import type uPlot from "uplot";

import { useText } from "../../text/text";
import { useLengths } from "../lengths";
import { inUnit, type Colour, type Plot } from "./plot";

const HEIGHT_PX = 340;

interface Key {
  name: string;
  colour: Colour;
  sign: string;
}

/** A picture over parts, angles or time. What it shows stands in a table too: `label` says what the picture is of, `at`
 * what stands at a place of it, for whoever points there. */
export function Chart({ plot: given, label, at, keys = [] }: { plot: Plot; label: string; at?: (k: number) => string; keys?: Key[] }) {
  const { unit } = useLengths();
  const plot = useMemo(() => inUnit(given, unit), [given, unit]);
  const place = useRef<HTMLDivElement>(null);
  const made = useRef<{ set: (plot: Plot) => void } | null>(null);
  const now = useRef(plot);
  const [pointed, point] = useState<number | null>(null);
  const [drawn, set] = useState(false);
  const dark = useComputedColorScheme("light") === "dark";
  const text = useText();
  const shape = `${dark} ${text("head.at")} ${plot.lines.map((one) => `${one.name} ${Boolean(one.band)}`).join("|")} ${plot.yName}`;
  now.current = plot;

  useEffect(() => {
    const box = place.current;
    if (!box) return undefined;
    return kept(box, () => now.current, point, (one) => {
      made.current = one;
      set(true);
    });
  }, [shape]);
  useEffect(() => made.current?.set(plot), [plot]);

  const said = pointed === null || pointed >= plot.x.length ? "" : (at?.(pointed) ?? "");
  return (
    <figure className="chart-box">
      {!drawn && <Loader role="status" aria-label={text("loading")} />}
      <div ref={place} className="chart" role="img" aria-label={label} />
      <figcaption>
        <ul className="key">
          {keys.map((one) => (
            <li key={one.name}>
              <span aria-hidden className={`sign ${one.colour}`}>
                {one.sign}
              </span>{" "}
              {one.name}
            </li>
          ))}
        </ul>
        <p className="pointed number">{said}</p>
      </figcaption>
    </figure>
  );
}

/** uPlot, loaded when the first picture is shown, in a box whose width it follows. */
function kept(
  box: HTMLElement,
  now: () => Plot,
  told: (at: number | null) => void,
  ready: (one: { set: (plot: Plot) => void } | null) => void,
): () => void {
  let chart: uPlot | undefined;
  let gone = false;
  const sized = new ResizeObserver(() => chart?.setSize({ width: box.clientWidth, height: HEIGHT_PX }));
  void Promise.all([import("uplot"), import("./draw"), import("uplot/dist/uPlot.min.css")]).then(([{ default: Made }, draw]) => {
    if (gone) return;
    chart = new Made(draw.optionsOf(now, box.clientWidth, HEIGHT_PX, told), draw.dataOf(now()), box);
    sized.observe(box);
    ready({ set: (plot) => chart?.setData(draw.dataOf(plot)) });
  });
  return () => {
    gone = true;
    sized.disconnect();
    chart?.destroy();
    ready(null);
  };
}
