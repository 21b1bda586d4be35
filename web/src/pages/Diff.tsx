import { useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { hash } from "../show/format";
import { Curves } from "../show/Curves";
import { Head, Section, Shown } from "../show/parts";
import { useProgramName } from "../show/program";
import { useText } from "../text/text";

const SIGN: Record<string, string> = { before: "−", after: "+" };

/** What is another in a program than in the one before it. */
export default function Diff({ id, of }: { id: string; of: string }) {
  const text = useText();
  const { name } = useProgramName();
  const found = useShown<Shape<"ProgramDiff">>(`programs/${encodeURIComponent(of)}/diff/${encodeURIComponent(id)}`);
  return (
    <>
      <Head title={text("head.diff")} />
      <Shown found={found}>
        {({ before, after, lines, differences }) => (
          <>
            <Section title={`${name(before)} → ${name(after)}`}>
            <p className="soft">
              <code>{hash(before.sha256)}</code> → <code>{hash(after.sha256)}</code>
            </p>
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
          {after.corrected && <Curves correction={after.corrected.correction} title={text("curve.title")} />}
          </>
        )}
      </Shown>
    </>
  );
}
