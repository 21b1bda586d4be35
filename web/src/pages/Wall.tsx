import { useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { ContactShown } from "../frame/Shell";
import { Head, Section, Shown, To } from "../show/parts";
import { useText } from "../text/text";
import { Counts, Machines } from "./Today";

const EVERY_S = 2;

/** Machines and counts to be read from far away: nothing to press but the way back. */
export default function Wall() {
  const text = useText();
  const today = useShown<Shape<"Today">>("today", EVERY_S);
  return (
    <main className="wall page">
      <Head title={text("today.machines")}>
        <ContactShown />
      </Head>
      <Shown found={today}>
        {({ machines, made }) => (
          <>
            <Machines machines={machines} />
            <Section title={text("today.made")}>
              <Counts made={made} />
            </Section>
          </>
        )}
      </Shown>
      <To href="/">{text("page.today")}</To>
    </main>
  );
}
