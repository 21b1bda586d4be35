import { useShown } from "../../api/asking";
import { piece, type Shape } from "../../api/client";
import { Age, Outcome, Rows, Section, Shown, To } from "../../show/parts";
import { useName, useText } from "../../text/text";

type Link = Shape<"LinkView">;
const HEADS = ["control", "kind", "where", "last", "outcome"] as const;

/** The link to each control: what it is, where it points, and what went over it last. Nothing is asked of a control. */
export function Links() {
  const text = useText();
  const found = useShown<Shape<"LinksView">>("links");
  return (
    <Section title={text("settings.links")}>
      <Shown found={found}>
        {({ settings, items }) => (
          <>
            {!settings && <p className="soft">{text("settings.links.untold")}</p>}
            <Listed links={items} />
          </>
        )}
      </Shown>
    </Section>
  );
}

function Listed({ links }: { links: Link[] }) {
  const text = useText();
  const word = useName();
  return (
    <Rows
      label={text("settings.links")}
      none={text("settings.links.none")}
      head={HEADS.map((one) => text(`head.${one}`))}
      rows={links.map(({ control, kind, where, machine, last }) => ({
        key: `${kind} ${control}`,
        cells: [
          machine ? <To href={`/machines/${piece(control)}`}>{control}</To> : control,
          <span className="whole">{word("link", kind) || "–"}</span>,
          where && <code>{where}</code>,
          last && (
            <>
              {last.program} {word("direction", last.direction)} <Age at={last.at} />
            </>
          ),
          last && <Outcome said={last.outcome} />,
        ],
      }))}
    />
  );
}
