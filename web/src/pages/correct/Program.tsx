import { Checkbox, NativeSelect, TextInput } from "@mantine/core";

import type { Shape } from "../../api/client";
import { EMPTY_LENGTH, keptOf, typed, type TypedLength } from "../../show/length";
import { Act, LengthInput } from "../../show/parts";
import { useName, useText } from "../../text/text";

type Asked = Shape<"AskedProgram">;
type Question = Shape<"Unstated">;

/** Another tool of a program. */
interface Tool {
  nose: TypedLength;
  tool: string;
  named: string;
}

/** What is stated of a program, as it was typed. */
export interface Stated {
  nose: TypedLength;
  tip: string;
  tool: string;
  named: string;
  tools: Tool[];
  zero: TypedLength;
  flipped: boolean;
  dialect: string;
  unit: string;
  lines: string;
  parameters: Record<string, string>;
  accepts: boolean;
  questions: Question[];
}

/** Answers that belong to the text of a program: none is sent with the next one. */
export const OF_PROGRAM = { dialect: "", unit: "", lines: "", parameters: {}, accepts: false, questions: [] };
const ONE = { nose: EMPTY_LENGTH, tool: "", named: "" };
export const NOTHING: Stated = { ...ONE, tip: "", tools: [], zero: EMPTY_LENGTH, flipped: false, ...OF_PROGRAM };
const TIPS = [...Array(10).keys()].map(String);

/** A number that counts, from 1, as it is typed; null for an empty field, NaN for text that is none. */
export function counted(text: string): number | null {
  const number = typed(text);
  return number === null || /^0*[1-9]\d*$/.test(text.trim()) ? number : NaN;
}

/** Two numbers of lines; null for an empty field, NaN for text that is not two. */
function twoLines(text: string): [number, number] | number | null {
  if (text.trim() === "") return null;
  const found = /^\s*(\d+)[\s,;–-]+(\d+)\s*$/.exec(text);
  return found ? [Number(found[1]), Number(found[2])] : NaN;
}

function noseOf(length: TypedLength): number | null {
  const nose = keptOf("mm", length);
  return nose !== null && nose < 0 ? NaN : nose;
}

/** What is sent of a program, whether a field holds what is no number, and what is still to be stated. */
export function askedOf(stated: Stated, program: string, several: { tools: boolean; setups: boolean }) {
  const tools = stated.tools.map((one) => ({ nose: noseOf(one.nose), tool: counted(one.tool), name: one.named.trim() }));
  const valued = Object.entries(stated.parameters).map(([name, one]) => [name, typed(one)] as const);
  const [nose, tool, zero, lines] = [noseOf(stated.nose), counted(stated.tool), keptOf("mm", stated.zero), twoLines(stated.lines)];
  const numbers = [nose, tool, zero, lines, ...tools.flatMap((one) => [one.nose, one.tool]), ...valued.map(([, one]) => one)];
  const asked: Asked = {
    program,
    nose_radius_mm: nose ?? 0,
    tip: stated.tip === "" ? null : Number(stated.tip),
    tool,
    tool_name: stated.named.trim(),
    tools: tools.map((one) => ({ nose_radius_mm: one.nose ?? 0, number: one.tool ?? 0, tip: null, name: one.name })),
    zero_at_z_mm: several.setups ? zero : null,
    flipped: several.setups && stated.flipped,
    dialect: stated.dialect || null,
    unit: stated.unit === "mm" || stated.unit === "inch" ? stated.unit : null,
    lines: Array.isArray(lines) ? lines : null,
    parameters: Object.fromEntries(valued.flatMap(([name, one]) => (one === null ? [] : [[name, one]]))),
    accept_unknown_words: stated.accepts,
  };
  const missing: "" | "correct.program.first" | "correct.nose.first" | "correct.tool.first" | "correct.zero.first" =
    (!program && "correct.program.first") ||
    ([nose, ...tools.map((one) => one.nose)].includes(null) && "correct.nose.first") ||
    (several.tools && [tool, ...tools.map((one) => one.tool)].includes(null) && "correct.tool.first") ||
    (several.setups && zero === null && "correct.zero.first") ||
    "";
  return { asked, wrong: numbers.some(Number.isNaN), missing };
}

interface OfProgram {
  of: Stated;
  set: (some: Partial<Stated>) => void;
  /** Whether several tools cut the part, and in several set-ups. */
  several: { tools: boolean; setups: boolean };
}

/** All that has to be stated of a program and of its tools. */
export function ProgramFields({ of, set, several }: OfProgram) {
  const text = useText();
  const word = useName();
  const bad = (wrong: boolean, key: "correct.no.number" | "correct.no.count" | "correct.no.lines") => wrong && text(key);
  const tool = (one: Tool, change: (some: Partial<Tool>) => void, k = 0) => (
    <>
      <LengthInput
        label={k ? text("correct.nose.of", { k }) : text("correct.nose")}
        of="mm"
        required
        error={bad(Number.isNaN(noseOf(one.nose)), "correct.no.number")}
        length={one.nose}
        change={(nose) => change({ nose })}
      />
      <TextInput
        label={several.tools ? text("correct.tool.of", { k: k || 1 }) : text("correct.tool")}
        description={k === 0 && text("correct.tool.why")}
        inputMode="numeric"
        required={several.tools}
        error={bad(Number.isNaN(counted(one.tool)), "correct.no.count")}
        value={one.tool}
        onChange={(event) => change({ tool: event.currentTarget.value })}
      />
      <TextInput
        label={several.tools ? text("correct.named.of", { k: k || 1 }) : text("correct.named")}
        description={k === 0 && text("correct.named.why")}
        value={one.named}
        onChange={(event) => change({ named: event.currentTarget.value })}
      />
    </>
  );
  const other = (k: number, some: Partial<Tool>) => set({ tools: of.tools.map((one, j) => (j === k ? { ...one, ...some } : one)) });
  return (
    <>
      <div className="two">
        {tool(of, set)}
        <NativeSelect
          label={text("correct.tip")}
          description={text("correct.tip.why")}
          value={of.tip}
          onChange={(event) => set({ tip: event.currentTarget.value })}
          data={[{ value: "", label: text("correct.tip.own") }, ...TIPS]}
        />
        {several.setups && (
          <>
            <LengthInput
              label={text("correct.zero")}
              of="mm"
              required
              error={bad(Number.isNaN(keptOf("mm", of.zero)), "correct.no.number")}
              length={of.zero}
              change={(zero) => set({ zero })}
            />
            <Checkbox size="lg" label={text("correct.flipped")} checked={of.flipped} onChange={(event) => set({ flipped: event.currentTarget.checked })} />
          </>
        )}
        {of.questions.map(({ about, choices = [] }) => {
          const own = { value: "", label: text("correct.own") };
          const field = (name: "dialect" | "unit" | "lines") => ({
            label: name === "unit" ? text("file.unit") : text(`correct.${name}`),
            value: of[name],
            onChange: (event: { currentTarget: { value: string } }) => set({ [name]: event.currentTarget.value }),
          });
          if (about === "dialect" || about === "unit")
            return <NativeSelect key={about} {...field(about)} data={[own, ...choices.map((value) => ({ value, label: word("dialect", value) }))]} />;
          if (about === "lines") return <TextInput key={about} error={bad(Number.isNaN(twoLines(of.lines)), "correct.no.lines")} {...field(about)} />;
          if (about === "accept_unknown_words")
            return <Checkbox key={about} size="lg" label={text("correct.accept")} checked={of.accepts} onChange={(event) => set({ accepts: event.currentTarget.checked })} />;
          return choices.map((name) => (
            <TextInput
              key={name}
              label={text("correct.parameter", { name })}
              inputMode="decimal"
              error={bad(Number.isNaN(typed(of.parameters[name] ?? "")), "correct.no.number")}
              value={of.parameters[name] ?? ""}
              onChange={(event) => set({ parameters: { ...of.parameters, [name]: event.currentTarget.value } })}
            />
          ));
        })}
      </div>
      {of.tools.map((one, j) => (
        <div key={j} className="two">
          {tool(one, (some) => other(j, some), j + 2)}
          <Act danger label={text("correct.tool.take", { k: j + 2 })} onClick={() => set({ tools: of.tools.filter((_, k) => k !== j) })} />
        </div>
      ))}
      <Act plain label={text("correct.tool.add")} onClick={() => set({ tools: [...of.tools, ONE] })} />
    </>
  );
}
