import { useShown } from "../api/asking";
import { piece, type Shape } from "../api/client";
import { Head, Rows, Section, Shown, To } from "../show/parts";
import { useText } from "../text/text";

/** Where to look: what makes the parts of a type wrong, and charts of their characteristics. */
export default function Diagnosis() {
  const text = useText();
  const found = useShown<{ items: Shape<"SeriesRow">[] }>("series");
  return (
    <>
      <Head title={text("page.diagnosis")} />
      <Section title={text("head.part_type")}>
        <Shown found={found}>
          {({ items }) => (
            <Rows
              label={text("page.diagnosis")}
              none={text("series.none")}
              head={[text("page.diagnosis"), text("chart.title")]}
              rows={[...new Set(items.map((one) => one.part_type))].map((type) => ({
                key: type,
                cells: [
                  <To href={`/diagnosis/${piece(type)}`}>{type}</To>,
                  <span className="acts">
                    {[...new Set(items.filter((one) => one.part_type === type).map((one) => one.characteristic))].map((name) => (
                      <To key={name} href={`/charts/${piece(type)}/${piece(name)}`}>
                        {name}
                      </To>
                    ))}
                  </span>,
                ],
              }))}
            />
          )}
        </Shown>
      </Section>
    </>
  );
}
