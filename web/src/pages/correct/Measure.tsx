import { NativeSelect, TextInput } from "@mantine/core";
import { useState } from "react";

import { useChange } from "../../api/asking";
import type { Shape } from "../../api/client";
import { moment, number } from "../../show/format";
import { EMPTY_LENGTH, keptOf, shownIn, typed, type TypedLength } from "../../show/length";
import { useReader } from "../../show/lengths";
import { Act, LengthInput, Notes, Refused, Rows, Section, useWhyNot } from "../../show/parts";
import { useName, useText } from "../../text/text";
import type { Seen } from "../Correct";
import { Content } from "../files/Content";

type Readings = Shape<"AskedReadings">;
type Size = Shape<"SizeToMeasure">;
const UNITS = ["mm", "inch"] as const;
const WAYS = ["auto", "offset", "contour"] as const;
const EMPTY = { serial: "", instrument: "", temperature: "", fileUnit: "", cut: "", by: "auto" };
interface OfMeasure extends Seen {
  /** What was corrected is not what stands here any more. */
  changed: () => void;
  done: (made: Shape<"CorrectedByHand">) => void;
  /** The program as it is known after a correction, for the part after this one; undefined: it could not be asked. */
  next: (part: Shape<"PartByHand"> | undefined) => void;
}

/** The part in a picture, the sizes with a field for each, and what else has to be stated of the part. */
export function Measure({ asked, part, file, changed, done, next }: OfMeasure) {
  const text = useText();
  const word = useName();
  const whyNot = useWhyNot()("operator");
  const reader = useReader();
  const correcting = useChange<Shape<"CorrectedByHand">>();
  const asking = useChange<Shape<"PartByHand">>();
  const [values, read] = useState<Record<string, string>>({});
  const [tolerances, tolerate] = useState<Record<string, string>>(part.tolerances ?? {});
  const [stated, state] = useState(EMPTY);
  const [lengths, type] = useState({ u: EMPTY_LENGTH, allowance: EMPTY_LENGTH });
  const field = (name: keyof typeof EMPTY) => ({
    value: stated[name],
    onChange: (event: { currentTarget: { value: string } }) => {
      const { value } = event.currentTarget;
      state((before) => ({ ...before, [name]: value }));
      changed();
    },
  });
  const length = (name: keyof typeof lengths) => ({
    length: lengths[name],
    change: (one: TypedLength) => {
      type((all) => ({ ...all, [name]: one }));
      changed();
    },
  });
  const given = Object.fromEntries(
    Object.entries(values)
      .map(([name, one]) => [name, one.split(";").map((each) => each.trim()).filter(Boolean)] as const)
      .filter(([, each]) => each.length > 0),
  );
  const [cut_with = "", cut_by] = stated.cut.split(" ");
  const u = keptOf("um", lengths.u);
  const allowance = keptOf("mm", lengths.allowance);
  const noU = u !== null && !(u > 0);
  const noAllowance = Number.isNaN(allowance);
  const temperature = typed(stated.temperature);
  const noTemperature = temperature !== null && !(temperature >= -50 && temperature <= 200);
  const before = part.made_before ?? [];
  const cuts = [
    { value: "given", label: text("correct.cut.given") },
    ...before.flatMap(({ id, made_at, serial, tool, ways }) => {
      const of = text("correct.cut.of", { id, serial, tool: tool || "–", at: moment(made_at) });
      if (ways.length === 0) return [{ value: id, label: text("correct.cut.all", { of }) }];
      return ways.map((way) => ({ value: `${id} ${way}`, label: text(`correct.cut.${way}`, { of }) }));
    }),
  ];
  const measured: Readings = {
    values: file ? {} : given,
    file: file?.sha256 ?? "",
    mapping_toml: file?.measurement?.mapping_toml ?? "",
    file_unit: UNITS.find((one) => one === stated.fileUnit) ?? null,
    serial: stated.serial.trim(),
    instrument: stated.instrument.trim(),
    expanded_uncertainty_um: u,
    measured_allowance_mm: allowance,
    temperature_c: file ? null : temperature,
    by: WAYS.find((one) => one === stated.by) ?? "auto",
    cut_with,
    cut_by: (["wear", "offsets", "corrected"] as const).find((one) => one === cut_by) ?? null,
    made_before: before.map(({ id }) => id),
    tolerances: file ? {} : limited(part, tolerances),
  };
  const why =
    whyNot ||
    (!file && Object.keys(given).length === 0 && text("correct.values.first")) ||
    (!file && !measured.serial && text("correct.serial.first")) ||
    ((noU || noAllowance || (!file && noTemperature)) && text("correct.wrong.first")) ||
    (before.length > 0 && !cut_with && !allowance && text("correct.cut.first")) ||
    "";
  const go = () =>
    correcting.mutate(
      { path: `by-hand/correction?${reader}`, body: { part: asked, measured } },
      {
        onSuccess: (made) => {
          done(made);
          read({});
          state((before) => ({ ...before, serial: "", cut: "" }));
          type((all) => ({ ...all, allowance: EMPTY_LENGTH }));
          asking.mutate(
            { path: `by-hand/part?${reader}`, body: asked },
            { onSuccess: (found) => next(found.problem ? undefined : found), onError: () => next(undefined) },
          );
        },
      },
    );
  return (
    <>
      <Section title={text("correct.part")}>
        <p>{text("correct.tools", { tools: (part.tools ?? []).join(", "), dialect: word("dialect", part.dialect) })}</p>
        {part.picture && <Drawn of={part.picture} />}
        {file ? (
          <>
            <p>{text("correct.from.file", { name: file.name })}</p>
            <Content view={file} />
          </>
        ) : (
          <>
            <p className="soft">{text("correct.how")}</p>
            <Sizes
              part={part}
              values={values}
              read={(name, one) => (read((all) => ({ ...all, [name]: one })), changed())}
              tolerances={tolerances}
              tolerate={(name, one) => (tolerate((all) => ({ ...all, [name]: one })), changed())}
            />
          </>
        )}
        <Notes of={part.notes ?? []} />
        <div className="fields">
          <div className="two">
            {file && (
              <NativeSelect label={text("correct.file.unit")} {...field("fileUnit")} data={[{ value: "", label: text("file.unit.own") }, ...UNITS]} />
            )}
            <TextInput label={text("correct.serial")} description={text("correct.serial.why")} required={!file} {...field("serial")} />
            <TextInput label={text("correct.instrument")} {...field("instrument")} />
            {!file && (
              <TextInput
                label={text("correct.temperature")}
                inputMode="decimal"
                error={noTemperature && text("correct.no.temperature")}
                {...field("temperature")}
              />
            )}
            <LengthInput label={text("correct.u")} of="um" error={noU && text("correct.no.u")} {...length("u")} />
            <LengthInput label={text("correct.allowance")} of="mm" error={noAllowance && text("correct.no.number")} {...length("allowance")} />
            {before.length > 0 && (
              <NativeSelect
                label={text("correct.cut")}
                description={stated.cut && cuts.find(({ value }) => value === stated.cut)?.label}
                {...field("cut")}
                data={[{ value: "", label: text("correct.cut.choose") }, ...cuts]}
              />
            )}
            <NativeSelect label={text("correct.by")} {...field("by")} data={WAYS.map((value) => ({ value, label: word("correct.by", value) }))} />
          </div>
          <Refused problem={correcting.error} />
          <Act label={text("correct.go")} why={why} busy={correcting.isPending || asking.isPending} onClick={go} />
        </div>
      </Section>
    </>
  );
}

/** A picture that came with an answer, on white as in the report. */
export function Drawn({ of }: { of: Shape<"Picture"> }) {
  const at = (svg: string) => `data:image/svg+xml,${encodeURIComponent(svg)}`;
  return (
    <picture>
      <source media="(max-width: 40rem)" srcSet={at(of.narrow)} />
      <img className="picture drawn" src={at(of.wide)} alt={of.said} />
    </picture>
  );
}

interface OfSizes {
  part: Seen["part"];
  values: Record<string, string>;
  read: (name: string, value: string) => void;
  tolerances: Record<string, string>;
  tolerate: (name: string, tolerance: string) => void;
}

/** The tolerances that are typed, of sizes on the sheet. */
function limited(part: Seen["part"], tolerances: Record<string, string>) {
  const names = new Set((part.sizes ?? []).map((of) => of.tolerance_name));
  const typed = Object.entries(tolerances).map(([name, one]) => [name, one.trim()] as const);
  return Object.fromEntries(typed.filter(([name, one]) => one && names.has(name)));
}

/** A row for each size by its number in the picture; values in the unit of the program. */
function Sizes({ part, values, read, tolerances, tolerate }: OfSizes) {
  const text = useText();
  const word = useName();
  const inch = part.unit === "inch";
  const unit = inch ? "in" : "mm";
  const said = (value: number | null | undefined, of: Size) =>
    number(value && of.quantity !== "angle" ? shownIn(part.unit, "mm", value) : value, inch ? 4 : 3);
  const sizes = part.sizes ?? [];
  const first = (of: Size) => sizes.find((one) => one.tolerance_name === of.tolerance_name) === of;
  const limits = (of: Size) =>
    of.tolerance_name === "" ? (
      <span className="number">{`${said(of.lower_limit, of)} … ${said(of.upper_limit, of)}`}</span>
    ) : (
      first(of) && (
        <TextInput
          aria-label={`${text("correct.tolerance", { unit })}: ${of.tolerance_name}`}
          placeholder={inch ? "±0.001" : "h6, ±0.02"}
          autoComplete="off"
          value={tolerances[of.tolerance_name] ?? ""}
          onChange={(event) => tolerate(of.tolerance_name, event.currentTarget.value)}
        />
      )
    );
  const what = (of: Size) => ({ diameter: "Ø", radius: "R" })[of.quantity] ?? word("quantity", of.quantity);
  return (
    <Rows
      label={text("correct.part")}
      none=""
      head={[text("correct.size"), text("head.feature"), text("head.nominal"), text("correct.at"), text("correct.measured", { unit }), text("correct.tolerance", { unit })]}
      rows={sizes.map((of) => ({
        key: of.name,
        cells: [
          <strong>{of.number}</strong>,
          `${of.feature}${of.other ? ` ${text("correct.from", { feature: of.other })}` : ""}`,
          <span className="number">
            {what(of)} {said(of.nominal, of)}
          </span>,
          <span className="number">{said(of.at_z_mm, of)}</span>,
          <TextInput
            aria-label={`${of.number} ${of.name}`}
            inputMode="decimal"
            autoComplete="off"
            value={values[of.name] ?? ""}
            onChange={(event) => read(of.name, event.currentTarget.value)}
          />,
          limits(of),
        ],
      }))}
    />
  );
}
