import { useEffect, useState } from "react";

/** Some servo periods of a corrector: the least and largest of every value, and the last period in words. */
export interface Stretch {
  at: string;
  record: string;
  axes: string;
  signals: string[];
  from: number;
  to: number;
  low: Record<string, number | null>;
  high: Record<string, number | null>;
  alarm: boolean;
  said: Record<string, string>;
}

export const WINDOW_S = 60;
const DRAWN_MS = 250;

/** The last minute of a machine's corrector, renewed as it comes. Another record begins anew. */
export function useTrace(machine: string): Stretch[] {
  const [shown, show] = useState<Stretch[]>([]);
  useEffect(() => {
    let kept: Stretch[] = [];
    let changed = false;
    const source = new EventSource(`/api/v1/machines/${encodeURIComponent(machine)}/corrector`);
    source.onmessage = ({ data }) => {
      const one = JSON.parse(String(data)) as Stretch;
      if (kept.at(-1)?.record !== one.record) kept = [];
      kept.push(one);
      kept = kept.filter(({ to }) => to >= one.to - WINDOW_S);
      changed = true;
    };
    const drawing = setInterval(() => {
      if (changed) show([...kept]);
      changed = false;
    }, DRAWN_MS);
    return () => {
      clearInterval(drawing);
      source.close();
    };
  }, [machine]);
  return shown;
}
