import { Checkbox, NativeSelect, TextInput } from "@mantine/core";
import { useState } from "react";

import { useChange } from "../../api/asking";
import type { Shape } from "../../api/client";
import { number } from "../../show/format";
import { EMPTY_LENGTH, keptOf, shownIn, typed, type TypedLength } from "../../show/length";
import { useReader } from "../../show/lengths";
import { Act, Length, LengthInput, Notes, Refused, Rows, Section, SizeDeviation, useWhyNot } from "../../show/parts";
import { useName, useText } from "../../text/text";
import { Content, Remarks } from "../files/Content";
import { counted } from "./Program";
import { Download } from "./Result";

type Upload = Shape<"UploadView">;
type Asked = Shape<"AskedMilled">;
type Part = Shape<"MilledPart">;
type Entries = Shape<"MilledEntries">;
type Question = Shape<"Unstated">;
const UNITS = ["mm", "inch"] as const;
const RECORD = /\.json$/i;

/** The values of one reading, separated by semicolons, of every field that has some. */
function valuesOf(fields: Record<string, string>) {
  const split = Object.entries(fields).map(([name, one]) => [name, one.split(";").map((each) => each.trim()).filter(Boolean)] as const);
  return Object.fromEntries(split.filter(([, each]) => each.length > 0));
}

/** A milled part: its program shown as features, what was measured, and the numbers to enter at the control. */
export function Milled() {
  const text = useText();
  const word = useName();
  const whyNot = useWhyNot()("operator");
  const reader = useReader();
  const sending = useChange<Upload>();
  const asking = useChange<Part>();
  const entering = useChange<Entries>();
  const [files, keep] = useState<{ program?: Upload; measurement?: Upload; record?: Upload }>({});
  const [cutters, cut] = useState<{ tool: string; radius: TypedLength }[]>([]);
  const [stated, state] = useState({ dialect: "", unit: "", wear: false, accepts: false, serial: "", fileUnit: "" });
  const [parameters, value] = useState<Record<string, string>>({});
  const [questions, ask] = useState<Question[]>([]);
  const [part, show] = useState<{ asked: Asked; seen: Part }>();
  const [fields, type] = useState<{ values: Record<string, string>; tolerances: Record<string, string>; names: Record<string, string> }>({ values: {}, tolerances: {}, names: {} });
  const [u, gauge] = useState(EMPTY_LENGTH);
  const take = async (given: FileList | null) => {
    for (const file of [...(given ?? [])]) {
      const found = await sending.mutateAsync({ path: `uploads?name=${encodeURIComponent(file.name)}`, file }).catch(() => undefined);
      if (!found) continue;
      const kind = RECORD.test(found.name) ? "record" : found.kind === "program" ? "program" : "measurement";
      keep((all) => ({ ...all, [kind]: found }));
      if (kind === "program") (ask([]), value({}), state((all) => ({ ...all, dialect: "", unit: "", accepts: false })), show(undefined));
    }
    entering.reset();
  };
  const set = (some: Partial<typeof stated>, again = true) => (state((all) => ({ ...all, ...some })), entering.reset(), again && show(undefined));
  const radii = cutters.map((one) => [counted(one.tool), keptOf("mm", one.radius)] as const);
  const valued = Object.entries(parameters).map(([name, one]) => [name, typed(one)] as const);
  const wrong = [...radii.flat(), ...valued.map(([, one]) => one)].some(Number.isNaN) || radii.some(([, radius]) => radius !== null && !(radius > 0));
  const look = () => {
    const asked: Asked = {
      program: files.program?.sha256 ?? "",
      cutters: Object.fromEntries(radii.flatMap(([tool, radius]) => (tool && radius ? [[tool, radius]] : []))),
      wear: stated.wear,
      name: "",
      dialect: stated.dialect || null,
      unit: UNITS.find((one) => one === stated.unit) ?? null,
      parameters: Object.fromEntries(valued.flatMap(([name, one]) => (one === null ? [] : [[name, one]]))),
      accept_unknown_words: stated.accepts,
    };
    asking.mutate(
      { path: `by-hand/milled?${reader}`, body: asked },
      {
        onSuccess: (seen) => {
          const { question } = seen;
          if (question) ask((all) => [...all.filter((one) => one.about !== question.about), question]);
          show(seen.problem ? undefined : { asked, seen });
        },
      },
    );
  };
  const gaugeU = keptOf("um", u);
  const given = valuesOf(fields.values);
  const file = files.measurement;
  const named = Object.entries(fields.names).filter(([, feature]) => feature);
  const go = () => {
    if (!part) return;
    const measured: Shape<"MilledReadings"> = {
      values: file ? {} : given,
      tolerances: file ? {} : Object.fromEntries(Object.entries(fields.tolerances).filter(([, one]) => one.trim())),
      file: file?.sha256 ?? "",
      file_unit: UNITS.find((one) => one === stated.fileUnit) ?? null,
      mapping_toml: file?.measurement?.mapping_toml ?? "",
      names: Object.fromEntries(named),
      serial: stated.serial.trim(),
      expanded_uncertainty_um: file ? null : gaugeU,
      entered: files.record?.sha256 ?? "",
    };
    entering.mutate({ path: `by-hand/entries?${reader}`, body: { part: part.asked, measured } });
  };
  const theirs = [...new Set((file?.measurement?.inspections ?? []).flatMap((one) => one.values.map((each) => each.feature)))].filter(Boolean);
  const enter = (kind: "values" | "tolerances" | "names", name: string, one: string) => (type((all) => ({ ...all, [kind]: { ...all[kind], [name]: one } })), entering.reset());
  const field = (kind: "values" | "tolerances", name: string, label: string, placeholder = "") => (
    <TextInput aria-label={label} autoComplete="off" placeholder={placeholder} value={fields[kind][name] ?? ""} onChange={(event) => enter(kind, name, event.currentTarget.value)} />
  );
  const own = { value: "", label: text("correct.own") };
  const seen = part?.seen;
  const inch = seen?.unit === "inch";
  const unit = inch ? "in" : "mm";
  const length = (value: number) => number(shownIn(seen?.unit ?? "mm", "mm", value), inch ? 4 : 3);
  return (
    <>
      <Section title={text("milled.files")}>
        <div
          className="drop"
          onDragOver={(event) => event.preventDefault()}
          onDrop={(event) => {
            event.preventDefault();
            if (!whyNot) void take(event.dataTransfer.files);
          }}
        >
          <label htmlFor="given">{text("milled.drop")}</label>
          <input id="given" type="file" multiple disabled={Boolean(whyNot)} onChange={(event) => (void take(event.currentTarget.files), (event.currentTarget.value = ""))} />
        </div>
        <Refused problem={sending.error} />
        {(["program", "measurement", "record"] as const).map(
          (kind) =>
            files[kind] && (
              <div key={kind} className="acts given">
                <p>
                  {text(kind === "record" ? "milled.record" : `file.${kind}`)}: {files[kind].name}
                </p>
                <Act
                  danger
                  label={text("correct.take", { name: files[kind].name })}
                  onClick={() => {
                    keep(({ [kind]: _, ...rest }) => rest);
                    entering.reset();
                    if (kind === "program") show(undefined);
                  }}
                />
              </div>
            ),
        )}
        <div className="fields">
          <div className="two">
            {questions.map(({ about, choices = [] }) =>
              about === "dialect" ? (
                <NativeSelect key={about} label={text("correct.dialect")} value={stated.dialect} onChange={(event) => set({ dialect: event.currentTarget.value })} data={[own, ...choices.map((one) => ({ value: one, label: word("dialect", one) }))]} />
              ) : about === "unit" ? (
                <NativeSelect key={about} label={text("file.unit")} value={stated.unit} onChange={(event) => set({ unit: event.currentTarget.value })} data={[own, ...choices]} />
              ) : about === "accept_unknown_words" ? (
                <Checkbox key={about} size="lg" label={text("correct.accept")} checked={stated.accepts} onChange={(event) => set({ accepts: event.currentTarget.checked })} />
              ) : (
                choices.map((name) => (
                  <TextInput key={name} label={text("correct.parameter", { name })} inputMode="decimal" value={parameters[name] ?? ""} onChange={(event) => (value({ ...parameters, [name]: event.currentTarget.value }), show(undefined))} />
                ))
              ),
            )}
            <Checkbox size="lg" label={text("milled.wear")} checked={stated.wear} onChange={(event) => set({ wear: event.currentTarget.checked })} />
          </div>
          <p className="soft">{text("milled.cutters")}</p>
          {cutters.map((one, k) => {
            const change = (some: Partial<typeof one>) => (cut(cutters.map((each, j) => (j === k ? { ...each, ...some } : each))), show(undefined));
            return (
              <div key={k} className="two">
                <TextInput label={text("milled.tool", { k: k + 1 })} inputMode="numeric" error={Number.isNaN(counted(one.tool)) && text("correct.no.count")} value={one.tool} onChange={(event) => change({ tool: event.currentTarget.value })} />
                <LengthInput label={text("milled.radius", { k: k + 1 })} of="mm" length={one.radius} change={(radius) => change({ radius })} error={Number.isNaN(keptOf("mm", one.radius)) && text("correct.no.number")} />
                <Act danger label={text("milled.cutter.take", { k: k + 1 })} onClick={() => (cut(cutters.filter((_, j) => j !== k)), show(undefined))} />
              </div>
            );
          })}
          <Act plain label={text("milled.cutter.add")} onClick={() => cut([...cutters, { tool: "", radius: EMPTY_LENGTH }])} />
          <Refused problem={asking.error} />
          {asking.data?.problem && (
            <div role="alert">
              <Remarks of={[asking.data.problem]} />
            </div>
          )}
          <Act label={text("correct.show")} why={whyNot || (!files.program && text("correct.program.first")) || (wrong && text("correct.wrong.first")) || ""} busy={asking.isPending || sending.isPending} onClick={look} />
        </div>
      </Section>
      {seen && (
        <Section title={text("correct.part")}>
          <Notes of={seen.notes ?? []} />
          <Rows
            label={text("milled.features")}
            none=""
            head={[text("head.feature"), `x y z, ${unit}`, text("milled.size", { unit }), text("milled.by"), ...(file ? [text("milled.name")] : [])]}
            rows={(seen.features ?? []).map((one) => ({
              key: one.name,
              cells: [
                `${one.name} (${word("milled.kind", one.kind)})`,
                one.at_mm.map(length).join(" "),
                <span className="number">{one.size_mm ? length(one.size_mm) : "–"}</span>,
                `${one.tool}, ${one.work_offset}, ${text(one.radius_at_control ? "milled.at.control" : "milled.in.path")}`,
                ...(file
                  ? [
                      <NativeSelect
                        aria-label={`${text("milled.name")}: ${one.name}`}
                        value={named.find(([, feature]) => feature === one.name)?.[0] ?? ""}
                        onChange={(event) => {
                          const chosen = event.currentTarget.value;
                          type((all) => ({ ...all, names: { ...Object.fromEntries(Object.entries(all.names).filter(([, of]) => of !== one.name)), ...(chosen && { [chosen]: one.name }) } }));
                          entering.reset();
                        }}
                        data={[{ value: "", label: theirs.includes(one.name) ? one.name : "–" }, ...theirs]}
                      />,
                    ]
                  : []),
              ],
            }))}
          />
          {file ? (
            <Content view={file} />
          ) : (
            <>
              <p className="soft">{text("milled.how")}</p>
              <Rows
                label={text("correct.part")}
                none=""
                head={[text("milled.what"), text("head.nominal"), text("correct.measured", { unit }), text("correct.tolerance", { unit })]}
                rows={(seen.sizes ?? []).map((one) => ({
                  key: one.name,
                  cells: [
                    `${one.feature}, ${word("milled.quantity", one.quantity)}`,
                    <span className="number">{length(one.nominal_mm)}</span>,
                    field("values", one.name, one.name),
                    field("tolerances", one.name, `${text("correct.tolerance", { unit })}: ${one.name}`, inch ? "±0.001" : "H7, ±0.02"),
                  ],
                }))}
              />
            </>
          )}
          <div className="fields">
            <div className="two">
              <TextInput label={text("milled.serial")} value={stated.serial} onChange={(event) => set({ serial: event.currentTarget.value }, false)} />
              {file ? (
                <NativeSelect label={text("correct.file.unit")} value={stated.fileUnit} onChange={(event) => set({ fileUnit: event.currentTarget.value }, false)} data={[{ value: "", label: text("file.unit.own") }, ...UNITS]} />
              ) : (
                <LengthInput label={text("correct.u")} of="um" length={u} change={(one) => (gauge(one), entering.reset())} error={gaugeU !== null && !(gaugeU > 0) && text("correct.no.u")} />
              )}
            </div>
            <p className="soft">{text(files.record ? "milled.entered" : "milled.entered.not")}</p>
            <Refused problem={entering.error} />
            <Act
              label={text("milled.go")}
              why={(!file && Object.keys(given).length === 0 && text("correct.values.first")) || (!file && gaugeU !== null && !(gaugeU > 0) && text("correct.wrong.first")) || ""}
              busy={entering.isPending}
              onClick={go}
            />
          </div>
        </Section>
      )}
      {entering.data && <Answer made={entering.data} />}
    </>
  );
}

/** What to enter at the control, and what to expect of the next part. */
function Answer({ made }: { made: Entries }) {
  const text = useText();
  return (
    <>
      <Section title={text("correct.result")}>
        <div role="status">
          {made.entries.map((one) => (
            <p key={one}>
              <strong className="enter">{one}</strong>
            </p>
          ))}
          {made.anything && <p>{text("milled.do")}</p>}
        </div>
        <p>{made.rms}</p>
        <p className={made.kept ? "soft" : "why"}>{text(made.kept ? "milled.kept" : "milled.kept.not")}</p>
        <Notes of={made.notes} />
        <div className="acts">
          {(made.files ?? []).map((one) => (
            <Download key={one.name} sha={one.sha256} name={one.name} />
          ))}
        </div>
      </Section>
      <Section title={text("correct.expected")}>
        <Rows
          label={text("correct.expected")}
          none=""
          head={[text("milled.what"), text("milled.last"), text("milled.unchanged"), text("milled.next"), text("head.expanded"), text("milled.in")]}
          rows={made.expected.map((one) => ({
            key: one.name,
            cells: [
              one.name,
              <SizeDeviation um={one.measured_um} />,
              <SizeDeviation um={one.unchanged_um} />,
              <SizeDeviation um={one.entered_um} />,
              <Length of="um" value={one.expanded_u_um} digits={1} />,
              one.probability_in === null ? "–" : `${number(100 * one.probability_in, 1)} %`,
            ],
          }))}
        />
      </Section>
    </>
  );
}
