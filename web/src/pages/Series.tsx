import { useShown } from "../api/asking";
import { piece, type Shape } from "../api/client";
import { Head, Rows, Section, Shown, SizeDeviation, To } from "../show/parts";
import { useText } from "../text/text";

const HEADS = ["characteristic", "part_type", "parts", "serial", "deviation", "next", "flags"] as const;

/** The address of a series. */
export const seriesAt = (part_type: string, characteristic: string) => `/series/${piece(part_type)}/${piece(characteristic)}`;

/** The series of all part types, each with its last part. */
export default function Series() {
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
              head={HEADS.map((one) => text(`head.${one}`))}
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
