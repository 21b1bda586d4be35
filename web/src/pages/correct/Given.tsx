import { Checkbox, NativeSelect, TextInput } from "@mantine/core";
import { useState, type Dispatch, type SetStateAction } from "react";

import { useChange } from "../../api/asking";
import type { Shape } from "../../api/client";
import { EMPTY_LENGTH, keptOf, typed } from "../../show/length";
import { useReader } from "../../show/lengths";
import { Act, LengthInput, Refused, Section, useWhyNot } from "../../show/parts";
import { useText } from "../../text/text";
import type { Seen } from "../Correct";
import { Remarks } from "../files/Content";

type Upload = Shape<"UploadView">;
type Kind = Upload["kind"];
type Part = Shape<"PartByHand">;
type Question = Shape<"Unstated">;
const KINDS: Kind[] = ["program", "drawing", "measurement"];

export type Files = { [kind in Kind]?: Upload | undefined };

/** A number that counts, from 1, as it is typed; null for an empty field, NaN for text that is none. */
function counted(text: string): number | null {
  const number = typed(text);
  return number === null || /^0*[1-9]\d*$/.test(text.trim()) ? number : NaN;
}

/** Two numbers of lines; null for an empty field, NaN for text that is not two. */
function twoLines(text: string): [number, number] | number | null {
  if (text.trim() === "") return null;
  const found = /^\s*(\d+)[\s,;–-]+(\d+)\s*$/.exec(text);
  return found ? [Number(found[1]), Number(found[2])] : NaN;
}

const TIPS = [...Array(10).keys()].map(String);
const OF_PROGRAM = { dialect: "", unit: "", outline: "", lines: "" };
const NOTHING = { nose: EMPTY_LENGTH, tip: "", tool: "", side: "outside", ...OF_PROGRAM };
interface OfGiven {
  files: Files;
  keep: Dispatch<SetStateAction<Files>>;
  busy: boolean;
  show: (seen: Seen | undefined) => void;
}

/** The finish program and its drawing, and all that has to be stated of them before the part can be shown. */
export function Given({ files, keep, busy, show }: OfGiven) {
  const text = useText();
  const whyNot = useWhyNot()("operator");
  const reader = useReader();
  const sending = useChange<Upload>();
  const asking = useChange<Part>();
  const [stated, state] = useState(NOTHING);
  const [parameters, value] = useState<Record<string, string>>({});
  const [accepts, accept] = useState(false);
  const [questions, ask] = useState<Question[]>([]);
  const changed = () => show(undefined);
  const set = (some: Partial<typeof NOTHING>) => {
    state((before) => ({ ...before, ...some }));
    changed();
  };
  /** Answers belong to the program and drawing that they were given for: none is sent with the next. */
  const forget = (kind: Kind) => {
    if (kind === "program") {
      state((before) => (files.program ? NOTHING : { ...before, ...OF_PROGRAM }));
      value({});
      accept(false);
      ask([]);
    } else if (kind === "drawing") {
      state((before) => ({ ...before, outline: "" }));
      ask((before) => before.filter(({ about }) => about !== "outline"));
    }
    asking.reset();
  };
  const take = async (given: FileList | null) => {
    for (const file of [...(given ?? [])]) {
      const path = `uploads?name=${encodeURIComponent(file.name)}`;
      const found = await sending.mutateAsync({ path, file }).catch(() => undefined);
      if (!found) continue;
      keep((before) => ({ ...before, [found.kind]: found }));
      forget(found.kind);
    }
    changed();
  };
  const nose = keptOf("mm", stated.nose);
  const lines = twoLines(stated.lines);
  const tool = counted(stated.tool);
  const outline = counted(stated.outline);
  const valued = Object.entries(parameters).map(([name, one]) => [name, typed(one)] as const);
  const wrong = [nose, tool, outline, lines, ...valued.map(([, one]) => one)].some(Number.isNaN) || (nose ?? 0) < 0;
  const body: Shape<"AskedPart"> = {
    program: files.program?.sha256 ?? "",
    drawing: files.drawing?.sha256 ?? "",
    name: "",
    zero: "drawing",
    nose_radius_mm: nose ?? 0,
    side: stated.side === "inside" ? "inside" : "outside",
    tip: stated.tip === "" ? null : Number(stated.tip),
    tool,
    dialect: stated.dialect || null,
    unit: stated.unit === "mm" || stated.unit === "inch" ? stated.unit : null,
    outline,
    lines: Array.isArray(lines) ? lines : null,
    parameters: Object.fromEntries(valued.flatMap(([name, one]) => (one === null ? [] : [[name, one]]))),
    accept_unknown_words: accepts,
  };
  const look = () =>
    asking.mutate(
      { path: `by-hand/part?${reader}`, body },
      {
        onSuccess: (part) => {
          const { question } = part;
          if (question) ask((before) => [...before.filter((one) => one.about !== question.about), question]);
          show(part.problem ? undefined : { asked: body, part, file: files.measurement });
        },
      },
    );
  const why =
    whyNot ||
    (!files.program && text("correct.program.first")) ||
    (nose === null && text("correct.nose.first")) ||
    (wrong && text("correct.wrong.first")) ||
    "";
  const bad = (number: unknown, key: "correct.no.number" | "correct.no.count" | "correct.no.lines" = "correct.no.number") =>
    Number.isNaN(number) && text(key);
  return (
    <Section title={text("correct.files")}>
      <div
        className="drop"
        onDragOver={(event) => event.preventDefault()}
        onDrop={(event) => {
          event.preventDefault();
          if (!whyNot && !busy) void take(event.dataTransfer.files);
        }}
      >
        <label htmlFor="given">{text("correct.drop")}</label>
        <input
          id="given"
          type="file"
          multiple
          disabled={Boolean(whyNot)}
          onChange={(event) => {
            void take(event.currentTarget.files);
            event.currentTarget.value = "";
          }}
        />
      </div>
      <Refused problem={sending.error} />
      {KINDS.map((kind) => files[kind] && <File key={kind} of={files[kind]} take={() => (keep({ ...files, [kind]: undefined }), forget(kind), changed())} />)}
      <div className="fields">
        <div className="two">
          <LengthInput label={text("correct.nose")} of="mm" required error={bad(nose) || ((nose ?? 0) < 0 && text("correct.no.number"))} length={stated.nose} change={(length) => set({ nose: length })} />
          <NativeSelect
            label={text("correct.tip")}
            description={text("correct.tip.why")}
            value={stated.tip}
            onChange={(event) => set({ tip: event.currentTarget.value })}
            data={[{ value: "", label: text("correct.tip.own") }, ...TIPS]}
          />
          <NativeSelect
            label={text("correct.side")}
            value={stated.side}
            onChange={(event) => set({ side: event.currentTarget.value })}
            data={(["outside", "inside"] as const).map((one) => ({ value: one, label: text(`correct.side.${one}`) }))}
          />
          <TextInput label={text("correct.tool")} description={text("correct.tool.why")} inputMode="numeric" error={bad(tool, "correct.no.count")} value={stated.tool} onChange={(event) => set({ tool: event.currentTarget.value })} />
          {questions.map(({ about, choices = [] }) => {
            const own = { value: "", label: text("correct.own") };
            const field = (name: "dialect" | "unit" | "outline" | "lines") => ({
              label: name === "unit" ? text("file.unit") : text(`correct.${name}`),
              value: stated[name],
              onChange: (event: { currentTarget: { value: string } }) => set({ [name]: event.currentTarget.value }),
            });
            if (about === "dialect" || about === "unit") return <NativeSelect key={about} {...field(about)} data={[own, ...choices]} />;
            if (about === "outline") return <TextInput key={about} inputMode="numeric" error={bad(outline, "correct.no.count")} {...field(about)} />;
            if (about === "lines") return <TextInput key={about} error={bad(lines, "correct.no.lines")} {...field(about)} />;
            if (about === "accept_unknown_words")
              return <Checkbox key={about} size="lg" label={text("correct.accept")} checked={accepts} onChange={(event) => (accept(event.currentTarget.checked), changed())} />;
            return choices.map((name) => (
              <TextInput
                key={name}
                label={text("correct.parameter", { name })}
                inputMode="decimal"
                error={bad(typed(parameters[name] ?? ""))}
                value={parameters[name] ?? ""}
                onChange={(event) => (value({ ...parameters, [name]: event.currentTarget.value }), changed())}
              />
            ));
          })}
        </div>
        <Refused problem={asking.error} />
        {asking.data?.problem && (
          <div role="alert">
            <Remarks of={[asking.data.problem]} />
          </div>
        )}
        <Act label={text("correct.show")} why={why} busy={asking.isPending || sending.isPending} onClick={look} />
      </div>
    </Section>
  );
}

/** A file that was handed over; one that was not read says why, unless the question below asks for it. */
function File({ of, take }: { of: Upload; take: () => void }) {
  const text = useText();
  return (
    <div className="acts given">
      <p>
        {text(`file.${of.kind}`)}: {of.name}
      </p>
      <Act danger label={text("correct.take", { name: of.name })} onClick={take} />
      {of.problem && of.kind !== "program" && <Remarks of={[of.problem]} />}
    </div>
  );
}
