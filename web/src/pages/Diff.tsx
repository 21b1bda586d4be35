import { useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { hash } from "../show/format";
import { Curves } from "../show/Curves";
import { Head, Section, Shown } from "../show/parts";
import { useText } from "../text/text";

const SIGN: Record<string, string> = { before: "−", after: "+" };

/** What is another in a program than in the one before it. */
export default function Diff({ id, of }: { id: string; of: string }) {
  const text = useText();
  const found = useShown<Shape<"ProgramDiff">>(`programs/${encodeURIComponent(of)}/diff/${encodeURIComponent(id)}`);
  return (
    <>
      <Head title={text("head.diff")} />
      <Shown found={found}>
        {({ before, after, lines, differences }) => (
          <>
          <Section title={`${before.name} ${hash(before.sha256)} → ${after.name} ${hash(after.sha256)}`}>
            <p className="soft">{text("diff.count", { count: differences })}</p>
            <div className="diff">
              {lines.map((line, k) => (
                <div key={k} className={line.change}>
                  <span>{line.before_line ?? ""}</span>
                  <span>{line.after_line ?? ""}</span>
                  <span>{SIGN[line.change] ?? ""}</span>
                  <span>{line.text}</span>
                </div>
              ))}
            </div>
          </Section>
          {after.made_from && <Curves correction={after.made_from} title={text("curve.title")} />}
          </>
        )}
      </Shown>
    </>
  );
}
