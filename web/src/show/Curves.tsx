import { useShown } from "../api/asking";
import { piece, type Shape } from "../api/client";
import { useText } from "../text/text";
import { useReader } from "./lengths";
import { Legend, Section, Shown } from "./parts";
import { Picture } from "./Picture";

/** The error curves behind a correction: what was touched, what was fitted, and what the cut should leave. */
export function Curves({ correction, title }: { correction: string; title: string }) {
  const text = useText();
  const path = `corrections/${piece(correction)}/curves`;
  const found = useShown<{ items: Shape<"CurvePicture">[] }>(`${path}?${useReader()}`);
  if (found.data?.items.length === 0) return null;
  return (
    <Section title={title}>
      <Shown found={found}>
        {({ items }) => (
          <>
            <p className="soft">{text("curve.key")}</p>
            <Legend />
            {items.map(({ number, said }) => (
              <figure key={number} className="curve">
                <Picture path={`${path}/${number}`} said={said} sizes />
                <figcaption className="soft">{said}</figcaption>
              </figure>
            ))}
          </>
        )}
      </Shown>
    </Section>
  );
}
