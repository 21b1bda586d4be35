import { Button, Checkbox, NativeSelect, Textarea, TextInput } from "@mantine/core";
import { useState, type FormEvent } from "react";
import { useLocation } from "wouter";

import { useChange, usePages, useShown } from "../api/asking";
import type { Shape } from "../api/client";
import { hash } from "../show/format";
import { Act, Head, Refused, Section, useWhyNot } from "../show/parts";
import { useName, useText } from "../text/text";

type Block = Shape<"Block">;
type Kind = Shape<"BlockKind">;
const KINDS: Kind[] = ["rough", "semifinish", "probe", "correct", "finish", "inspect", "remove", "measure", "release"];
const MOVES: Kind[] = ["rough", "semifinish", "probe", "finish", "inspect"];
const FIRST: Block[] = (["semifinish", "probe", "correct", "finish", "remove", "measure"] as const).map((kind) => ({
  kind,
  program_sha256: "",
  feature: "",
  corrected: kind === "finish",
}));

const EMPTY = { part_type: "", revision: "", machine: "", serials: "", job_toml: "", probe_toml: "" };
/** The choice of a machine that the store does not know yet. */
const NEW = "\0";

/** A new order. Whether it can be made the service judges; what it refuses is shown. */
export default function Plan() {
  const text = useText();
  const whyNot = useWhyNot();
  const [, go] = useLocation();
  const [fields, setFields] = useState(EMPTY);
  const [blocks, setBlocks] = useState(FIRST);
  const [chosen, setChosen] = useState("");
  const machines = useShown<{ items: Shape<"MachineNow">[] }>("machines").data?.items ?? [];
  const planning = useChange<Shape<"OrderView">>();

  function submit(event: FormEvent) {
    event.preventDefault();
    const serials = fields.serials.split("\n").map((one) => one.trim()).filter(Boolean);
    planning.mutate(
      { path: "orders", body: { ...fields, ...named(), serials, blocks } },
      { onSuccess: (made) => go(`/orders/${encodeURIComponent(made.row.id)}`) },
    );
  }
  function named() {
    return chosen === NEW ? { new_machine: true } : { machine: chosen };
  }
  function field(name: keyof typeof fields) {
    const set = (event: { currentTarget: { value: string } }) => {
      const { value } = event.currentTarget;
      setFields((before) => ({ ...before, [name]: value }));
    };
    return { value: fields[name], onChange: set };
  }
  return (
    <>
      <Head title={text("order.plan")} />
      <form className="fields" onSubmit={submit}>
        <Section title={text("order.parts")}>
          <div className="fields">
            <div className="two">
              <TextInput label={text("head.part_type")} required {...field("part_type")} />
              <TextInput label={text("order.revision")} {...field("revision")} />
              <NativeSelect
                label={text("head.machine")}
                required
                value={chosen}
                onChange={(event) => setChosen(event.currentTarget.value)}
                data={[
                  { value: "", label: text("order.machine.choose") },
                  ...machines.map(({ name }) => ({ value: name, label: name })),
                  { value: NEW, label: text("order.machine.new") },
                ]}
              />
              {chosen === NEW && <TextInput label={text("order.machine.name")} required {...field("machine")} />}
            </div>
            <Textarea label={text("order.serials")} rows={4} required {...field("serials")} />
            <Textarea label={text("order.job")} rows={4} {...field("job_toml")} />
            <Textarea label={text("order.probe")} rows={4} {...field("probe_toml")} />
          </div>
        </Section>
        <Section title={text("order.route")}>
          <RouteFields blocks={blocks} set={setBlocks} />
        </Section>
        <Refused problem={planning.error} />
        <Act submit label={text("order.plan")} why={whyNot("engineer")} busy={planning.isPending} />
      </form>
    </>
  );
}

function RouteFields({ blocks, set }: { blocks: Block[]; set: (blocks: Block[]) => void }) {
  const text = useText();
  return (
    <>
      {blocks.map((block, no) => (
        <StepFields
          key={no}
          no={no}
          block={block}
          set={(changed) => set(blocks.map((one, k) => (k === no ? { ...one, ...changed } : one)))}
        />
      ))}
      <div className="acts">
        <Button
          variant="default"
          onClick={() => set([...blocks, { kind: "release", program_sha256: "", feature: "", corrected: false }])}
        >
          {text("order.step.add")}
        </Button>
        <Button variant="default" disabled={blocks.length < 2} onClick={() => set(blocks.slice(0, -1))}>
          {text("order.step.take")}
        </Button>
      </div>
    </>
  );
}

function StepFields({ no, block, set }: { no: number; block: Block; set: (changed: Partial<Block>) => void }) {
  const text = useText();
  const word = useName();
  const programs = usePages<Shape<"ProgramRow">>("programs?limit=200");
  const released = (programs.data ?? []).filter((one) => one.released);
  const moves = MOVES.includes(block.kind);
  return (
    <fieldset className="step">
      <legend>{text("order.step.kind", { no })}</legend>
      <div className="two">
        <NativeSelect
          label={text("head.step")}
          value={block.kind}
          onChange={(event) => {
            const kind = event.currentTarget.value as Kind;
            set({ kind, corrected: false, ...(MOVES.includes(kind) ? {} : { program_sha256: "", feature: "" }) });
          }}
          data={KINDS.map((kind) => ({ value: kind, label: word("kind", kind) }))}
        />
        {moves && (
          <NativeSelect
            label={text("order.step.program")}
            value={block.program_sha256 ?? ""}
            onChange={(event) => set({ program_sha256: event.currentTarget.value })}
            data={[
              { value: "", label: text("order.program.none") },
              ...released.map((one) => ({ value: one.sha256, label: `${one.name} ${hash(one.sha256)}` })),
            ]}
          />
        )}
        {moves && (
          <TextInput
            label={text("order.step.feature")}
            value={block.feature ?? ""}
            onChange={(event) => set({ feature: event.currentTarget.value })}
          />
        )}
        {block.kind === "finish" && (
          <Checkbox
            size="lg"
            label={text("order.step.corrected")}
            checked={block.corrected ?? false}
            onChange={(event) => set({ corrected: event.currentTarget.checked })}
          />
        )}
      </div>
    </fieldset>
  );
}
