import { NativeSelect, Textarea } from "@mantine/core";
import { useEffect, useState } from "react";

import { useChange } from "../../api/asking";
import type { Shape } from "../../api/client";
import { Act, Refused, Section } from "../../show/parts";
import { DIALECTS, useName, useText } from "../../text/text";
import { Keep } from "./Keep";
import { Content } from "./Content";

type View = Shape<"UploadView">;
type Asked = Shape<"ReadingOptions">;
const KINDS = ["program", "measurement", "drawing"] as const;
const UNITS = ["", "mm", "inch"] as const;

/** One file: sent, read, shown, read in another way where that was wrong, and then kept. */
export function Handed({ file }: { file: File }) {
  const text = useText();
  const word = useName();
  const reading = useChange<View>();
  const [view, show] = useState<View>();
  const [asked, ask] = useState<Asked>({ kind: null, dialect: null, unit: null, order: "", mapping_toml: "" });
  const [changed, change] = useState(false);
  const set = (some: Partial<Asked>) => {
    ask({ ...asked, ...some });
    change(true);
  };
  const read = (found: View) => {
    const mapping_toml = found.measurement?.mapping_toml || found.mapping_toml;
    show(found);
    ask((before) => ({ ...before, kind: found.kind, mapping_toml }));
    change(false);
  };
  const send = () => reading.mutate({ path: `uploads?name=${encodeURIComponent(file.name)}`, file }, { onSuccess: read });
  useEffect(send, []);
  const again = () => reading.mutate({ path: `uploads/${view?.sha256}/read`, body: asked }, { onSuccess: read });
  return (
    <Section title={file.name}>
      <Refused problem={reading.error} />
      {!view && <Act label={text("file.send")} busy={reading.isPending} onClick={send} />}
      {view && (
        <>
          <Content view={view} />
          <div className="fields">
            <div className="two">
              <NativeSelect
                label={text("file.kind")}
                value={asked.kind ?? view.kind}
                onChange={(event) => set({ kind: event.currentTarget.value as View["kind"], mapping_toml: "" })}
                data={KINDS.map((value) => ({ value, label: text(`file.${value}`) }))}
              />
              <NativeSelect
                label={text("file.unit")}
                value={asked.unit ?? ""}
                onChange={(event) => set({ unit: UNITS.find((one) => one && one === event.currentTarget.value) || null })}
                data={UNITS.map((value) => ({ value, label: value || text("file.unit.own") }))}
              />
              {(asked.kind ?? view.kind) === "program" && (
                <NativeSelect
                  label={text("head.dialect")}
                  value={asked.dialect ?? view.program?.dialect ?? ""}
                  onChange={(event) => set({ dialect: event.currentTarget.value || null })}
                  data={[{ value: "", label: text("correct.own") }, ...DIALECTS.map((value) => ({ value, label: word("dialect", value) }))]}
                />
              )}
            </div>
            {asked.mapping_toml && (
              <Textarea
                label={text("file.mapping")}
                rows={10}
                value={asked.mapping_toml}
                onChange={(event) => set({ mapping_toml: event.currentTarget.value })}
              />
            )}
            <Act label={text("file.read")} busy={reading.isPending} onClick={again} />
          </div>
          <Keep view={view} asked={asked} changed={changed} />
        </>
      )}
    </Section>
  );
}
