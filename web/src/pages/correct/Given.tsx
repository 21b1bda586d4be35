import { Checkbox, NativeSelect, TextInput } from "@mantine/core";
import { useState } from "react";

import { useChange } from "../../api/asking";
import type { Shape } from "../../api/client";
import { useLengths, useReader } from "../../show/lengths";
import { Act, Refused, Section, useWhyNot } from "../../show/parts";
import { useText } from "../../text/text";
import type { Seen } from "../Correct";
import { Remarks } from "../files/Content";

type Upload = Shape<"UploadView">;
type Kind = Upload["kind"];
type Part = Shape<"PartByHand">;
type Question = Shape<"Unstated">;
const KINDS: Kind[] = ["program", "drawing", "measurement"];
export const MM_PER_INCH = 25.4;

/** A number as it is typed, with a point or a comma; null for none. */
export function typed(text: string): number | null {
  const number = Number(text.trim().replace(",", "."));
  return text.trim() === "" || !Number.isFinite(number) ? null : number;
}

const NOTHING = { nose: "", tool: "", side: "outside", dialect: "", unit: "", outline: "", lines: "" };

/** The finish program and its drawing, and all that has to be stated of them before the part can be shown. */
export function Given({ show }: { show: (seen: Seen | undefined) => void }) {
  const text = useText();
  const whyNot = useWhyNot()("operator");
  const inch = useLengths().unit === "inch";
  const reader = useReader();
  const sending = useChange<Upload>();
  const asking = useChange<Part>();
  const [files, keep] = useState<Partial<Record<Kind, Upload>>>({});
  const [stated, state] = useState(NOTHING);
  const [parameters, value] = useState<Record<string, string>>({});
  const [accepts, accept] = useState(false);
  const [questions, ask] = useState<Question[]>([]);
  const changed = () => show(undefined);
  const set = (some: Partial<typeof NOTHING>) => {
    state((before) => ({ ...before, ...some }));
    changed();
  };
  const take = async (given: FileList | null) => {
    for (const file of [...(given ?? [])]) {
      const path = `uploads?name=${encodeURIComponent(file.name)}`;
      const found = await sending.mutateAsync({ path, file }).catch(() => undefined);
      if (found) keep((before) => ({ ...before, [found.kind]: found }));
      if (found?.kind === "program") ask([]);
    }
    changed();
  };
  const nose = typed(stated.nose);
  const lines = stated.lines.split(/[^\d]+/).map(Number);
  const body: Shape<"AskedPart"> = {
    program: files.program?.sha256 ?? "",
    drawing: files.drawing?.sha256 ?? "",
    name: "",
    zero: "drawing",
    nose_radius_mm: (nose ?? 0) * (inch ? MM_PER_INCH : 1),
    side: stated.side === "inside" ? "inside" : "outside",
    tool: typed(stated.tool),
    dialect: stated.dialect || null,
    unit: stated.unit === "mm" || stated.unit === "inch" ? stated.unit : null,
    outline: typed(stated.outline),
    lines: lines.length === 2 ? [lines[0] ?? 0, lines[1] ?? 0] : null,
    parameters: Object.fromEntries(Object.entries(parameters).map(([name, one]) => [name, typed(one) ?? 0])),
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
  const why = whyNot || (!files.program ? text("correct.program.first") : nose === null ? text("correct.nose.first") : "");
  return (
    <Section title={text("correct.files")}>
      <div
        className="drop"
        onDragOver={(event) => event.preventDefault()}
        onDrop={(event) => {
          event.preventDefault();
          if (!whyNot) void take(event.dataTransfer.files);
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
      {KINDS.map((kind) => files[kind] && <File key={kind} of={files[kind]} take={() => (keep({ ...files, [kind]: undefined }), changed())} />)}
      <div className="fields">
        <div className="two">
          <TextInput label={text("correct.nose")} inputMode="decimal" required value={stated.nose} onChange={(event) => set({ nose: event.currentTarget.value })} />
          <NativeSelect
            label={text("correct.side")}
            value={stated.side}
            onChange={(event) => set({ side: event.currentTarget.value })}
            data={(["outside", "inside"] as const).map((one) => ({ value: one, label: text(`correct.side.${one}`) }))}
          />
          <TextInput label={text("correct.tool")} inputMode="numeric" value={stated.tool} onChange={(event) => set({ tool: event.currentTarget.value })} />
          {questions.map(({ about, choices = [] }) => {
            const own = { value: "", label: text("correct.own") };
            const field = (name: "dialect" | "unit" | "outline" | "lines") => ({
              label: name === "unit" ? text("file.unit") : text(`correct.${name}`),
              value: stated[name],
              onChange: (event: { currentTarget: { value: string } }) => set({ [name]: event.currentTarget.value }),
            });
            if (about === "dialect" || about === "unit") return <NativeSelect key={about} {...field(about)} data={[own, ...choices]} />;
            if (about === "outline" || about === "lines") return <TextInput key={about} inputMode="numeric" {...field(about)} />;
            if (about === "accept_unknown_words")
              return <Checkbox key={about} size="lg" label={text("correct.accept")} checked={accepts} onChange={(event) => (accept(event.currentTarget.checked), changed())} />;
            return choices.map((name) => (
              <TextInput
                key={name}
                label={text("correct.parameter", { name })}
                inputMode="decimal"
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
