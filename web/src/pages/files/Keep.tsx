import { NativeSelect } from "@mantine/core";
import { useState } from "react";

import { useChange, usePages, useShown } from "../../api/asking";
import type { Shape } from "../../api/client";
import { Act, Refused, To, useWhyNot } from "../../show/parts";
import { useName, useText } from "../../text/text";
import { Remarks } from "./Content";

type View = Shape<"UploadView">;
type Asked = Shape<"ReadingOptions">;
type Imported = Shape<"ImportedView">;
interface Given {
  view: View;
  asked: Asked;
  changed: boolean;
}

/** What was read is made a fact, as it was read; nothing is kept of a drawing, which is for a job. */
export function Keep(given: Given) {
  if (given.view.program) return <KeepProgram {...given} />;
  return given.view.measurement ? <KeepMeasurement {...given} /> : null;
}

function KeepProgram({ view, asked, changed }: Given) {
  const text = useText();
  const keeping = useChange<Imported>();
  const body = { dialect: view.program?.dialect, unit: asked.unit };
  return (
    <div className="fields">
      <Refused problem={keeping.error} />
      <KeepButton changed={changed} keeping={keeping} path={`uploads/${view.sha256}/program`} body={body} />
      {keeping.data && <To href="/programs">{text("page.programs")}</To>}
    </div>
  );
}

function KeepMeasurement({ view, asked, changed }: Given) {
  const text = useText();
  const word = useName();
  const keeping = useChange<Imported>();
  const orders = usePages<Shape<"OrderRow">>("orders");
  const [of, set] = useState({ order: "", part: "", after: "released", run: "" });
  const { unit, mapping_toml } = asked;
  const body = { order: of.order, part: Number(of.part), after: of.after, run: Number(of.run) || null, unit, mapping_toml };
  const runs = view.measurement?.inspections ?? [];
  return (
    <div className="fields">
      <div className="two">
        <NativeSelect
          label={text("head.order")}
          value={of.order}
          onChange={(event) => set({ ...of, order: event.currentTarget.value, part: "" })}
          data={[
            { value: "", label: text("order.program.none") },
            ...(orders.data ?? []).map((one) => ({ value: one.id, label: `${one.id} ${one.part_type}` })),
          ]}
        />
        {of.order && <Part order={of.order} value={of.part} choose={(part) => set({ ...of, part })} />}
        <NativeSelect
          label={text("file.after")}
          value={of.after}
          onChange={(event) => set({ ...of, after: event.currentTarget.value })}
          data={[
            ...["semifinish", "finish"].map((value) => ({ value, label: word("kind", value) })),
            { value: "released", label: word("state", "removed") },
          ]}
        />
        {runs.length > 1 && (
          <NativeSelect
            label={text("file.run")}
            value={of.run}
            onChange={(event) => set({ ...of, run: event.currentTarget.value })}
            data={[
              { value: "", label: text("file.run.own") },
              ...runs.map((one) => ({ value: String(one.run), label: `${one.run} ${one.serial}` })),
            ]}
          />
        )}
      </div>
      <Refused problem={keeping.error} />
      <KeepButton
        changed={changed}
        why={of.part ? "" : text("file.part.missing")}
        keeping={keeping}
        path={`uploads/${view.sha256}/measurement`}
        body={body}
      />
      {keeping.data && <To href={`/parts/${of.part}`}>{text("head.part")}</To>}
    </div>
  );
}

function Part({ order, value, choose }: { order: string; value: string; choose: (part: string) => void }) {
  const text = useText();
  const found = useShown<Shape<"OrderView">>(`orders/${encodeURIComponent(order)}`);
  return (
    <NativeSelect
      label={text("head.part")}
      value={value}
      onChange={(event) => choose(event.currentTarget.value)}
      data={[
        { value: "", label: text("order.program.none") },
        ...(found.data?.parts ?? []).map((one) => ({ value: String(one.id), label: one.serial })),
      ]}
    />
  );
}

interface Button {
  changed: boolean;
  why?: string;
  keeping: ReturnType<typeof useChange<Imported>>;
  path: string;
  body: object;
}

function KeepButton({ changed, why = "", keeping, path, body }: Button) {
  const text = useText();
  const whyNot = useWhyNot();
  const kept = keeping.data;
  return (
    <>
      <Act
        label={text("file.keep")}
        busy={keeping.isPending}
        why={whyNot("operator") || (changed ? text("file.read.first") : why)}
        onClick={() => keeping.mutate({ path, body })}
      />
      {kept && (
        <div role="status">
          {text("file.kept", { kept: kept.kept, new: kept.new })} {kept.recorded && text("file.recorded")}
          <Remarks of={kept.remarks} />
        </div>
      )}
    </>
  );
}
