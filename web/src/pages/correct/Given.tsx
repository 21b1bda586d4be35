import { NativeSelect, TextInput } from "@mantine/core";
import { useState, type Dispatch, type SetStateAction } from "react";

import { useChange } from "../../api/asking";
import type { Shape } from "../../api/client";
import { useReader } from "../../show/lengths";
import { Act, Refused, Section, useWhyNot } from "../../show/parts";
import { useText } from "../../text/text";
import type { Seen } from "../Correct";
import { Remarks } from "../files/Content";
import { askedOf, counted, NOTHING, OF_PROGRAM, ProgramFields, type Stated } from "./Program";

type Upload = Shape<"UploadView">;
type Kind = Upload["kind"];
type Part = Shape<"PartByHand">;
const SIDES = ["outside", "inside", "around"] as const;

/** The files that were handed over: a program for each set-up, and one of every other kind. */
export interface Files {
  programs: (Upload | undefined)[];
  drawing?: Upload | undefined;
  measurement?: Upload | undefined;
}

interface OfGiven {
  files: Files;
  keep: Dispatch<SetStateAction<Files>>;
  busy: boolean;
  show: (seen: Seen | undefined) => void;
}

/** The finish programs and the drawing, and all that has to be stated of them before the part can be shown. */
export function Given({ files, keep, busy, show }: OfGiven) {
  const text = useText();
  const whyNot = useWhyNot()("operator");
  const reader = useReader();
  const sending = useChange<Upload>();
  const asking = useChange<Part>();
  const [stated, state] = useState<Stated[]>([NOTHING]);
  const [side, turn] = useState<(typeof SIDES)[number]>("outside");
  const [outline, choose] = useState<string>();
  const set = (k: number, some: Partial<Stated>) => {
    state((all) => all.map((one, j) => (j === k ? { ...one, ...some } : one)));
    show(undefined);
  };
  /** Answers belong to the program and drawing that they were given for: none is sent with the next. */
  const put = (found: Upload, kind: Kind, k: number) => {
    if (kind !== "program") {
      keep((before) => ({ ...before, [kind]: found }));
      if (kind === "drawing") choose(undefined);
      return;
    }
    keep((before) => {
      const programs = [...before.programs];
      programs[k] = found;
      return { ...before, programs };
    });
    state((all) => {
      const next = [...all];
      next[k] = files.programs[k] ? NOTHING : { ...(all[k] ?? NOTHING), ...OF_PROGRAM };
      return next;
    });
  };
  const take = async (given: FileList | null, first = 0) => {
    let k = first;
    for (const file of [...(given ?? [])]) {
      const path = `uploads?name=${encodeURIComponent(file.name)}`;
      const found = await sending.mutateAsync({ path, file }).catch(() => undefined);
      if (!found) continue;
      put(found, found.kind, k);
      k += Number(found.kind === "program"); // several at once are of one set-up after the other
    }
    asking.reset();
    show(undefined);
  };
  const remove = (kind: "drawing" | "measurement" | number) => {
    if (typeof kind !== "number") keep((all) => ({ ...all, [kind]: undefined }));
    else if (kind === 0) {
      keep((all) => ({ ...all, programs: [undefined, ...all.programs.slice(1)] }));
      state(([, ...then]) => [NOTHING, ...then]);
    } else {
      keep((all) => ({ ...all, programs: all.programs.filter((_, j) => j !== kind) }));
      state((all) => all.filter((_, j) => j !== kind));
    }
    if (kind === "drawing") choose(undefined);
    asking.reset();
    show(undefined);
  };
  const several = { tools: stated.length > 1 || stated.some((one) => one.tools.length > 0), setups: stated.length > 1 };
  const made = stated.map((one, k) => askedOf(one, files.programs[k]?.sha256 ?? "", several));
  const [first, ...then] = made.map((one) => one.asked);
  const contour = counted(outline ?? "");
  const wrong = made.some((one) => one.wrong) || Number.isNaN(contour);
  const missing = made.find((one) => one.missing)?.missing;
  const look = () => {
    if (!first) return;
    const body: Shape<"AskedPart"> = { ...first, then, drawing: files.drawing?.sha256 ?? "", name: "", zero: "drawing", side, outline: contour };
    asking.mutate(
      { path: `by-hand/part?${reader}`, body },
      {
        onSuccess: (part) => {
          const { question } = part;
          if (question?.about === "outline") choose((before) => before ?? "");
          else if (question) {
            const k = question.program ?? 0;
            const others = (stated[k] ?? NOTHING).questions.filter((one) => one.about !== question.about);
            set(k, { questions: [...others, question] });
          }
          show(part.problem ? undefined : { asked: body, part, file: files.measurement });
        },
      },
    );
  };
  const why =
    whyNot ||
    (missing && text(missing)) ||
    (wrong && text("correct.wrong.first")) ||
    (several.tools && !files.drawing && text("correct.drawing.first")) ||
    "";
  const drop = (k: number, label: string) => (
    <div
      className="drop"
      onDragOver={(event) => event.preventDefault()}
      onDrop={(event) => {
        event.preventDefault();
        if (!whyNot && !busy) void take(event.dataTransfer.files, k);
      }}
    >
      <label htmlFor={`given-${k}`}>{label}</label>
      <input
        id={`given-${k}`}
        type="file"
        multiple
        disabled={Boolean(whyNot)}
        onChange={(event) => {
          void take(event.currentTarget.files, k);
          event.currentTarget.value = "";
        }}
      />
    </div>
  );
  const program = (k: number) => files.programs[k] && <File of={files.programs[k]} take={() => remove(k)} />;
  return (
    <Section title={text("correct.files")}>
      {drop(0, text("correct.drop"))}
      <Refused problem={sending.error} />
      {!several.setups && program(0)}
      {(["drawing", "measurement"] as const).map((kind) => files[kind] && <File key={kind} of={files[kind]} take={() => remove(kind)} />)}
      <div className="fields">
        <div className="two">
          <NativeSelect
            label={text("correct.side")}
            value={side}
            onChange={(event) => (turn(SIDES.find((one) => one === event.currentTarget.value) ?? "outside"), show(undefined))}
            data={SIDES.map((one) => ({ value: one, label: text(`correct.side.${one}`) }))}
          />
          {outline !== undefined && (
            <TextInput
              label={text("correct.outline")}
              inputMode="numeric"
              error={Number.isNaN(contour) && text("correct.no.count")}
              value={outline}
              onChange={(event) => (choose(event.currentTarget.value), show(undefined))}
            />
          )}
        </div>
        {stated.map((one, k) => {
          const fields = <ProgramFields of={one} set={(some) => set(k, some)} several={several} />;
          if (!several.setups) return <div key={k} className="fields">{fields}</div>;
          return (
            <fieldset key={k} className="step">
              <legend>{text("correct.setup", { k: k + 1 })}</legend>
              {program(k) ?? drop(k, text("correct.setup.drop", { k: k + 1 }))}
              <div className="fields">{fields}</div>
              {k > 0 && <Act danger label={text("correct.setup.take", { k: k + 1 })} onClick={() => remove(k)} />}
            </fieldset>
          );
        })}
        <Act plain label={text("correct.setup.add")} onClick={() => (state((all) => [...all, NOTHING]), show(undefined))} />
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
