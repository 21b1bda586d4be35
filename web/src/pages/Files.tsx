import { useRef, useState } from "react";

import { Head, Section, useWhyNot } from "../show/parts";
import { useText } from "../text/text";
import { Handed } from "./files/Handed";

/** Files handed over by dropping or choosing them: each is read and shown, and kept only when that is pressed. */
export default function Files() {
  const text = useText();
  const why = useWhyNot()("operator");
  const next = useRef(0);
  const [files, set] = useState<{ key: number; file: File }[]>([]);
  const take = (given: FileList | null) =>
    set((before) => [...[...(given ?? [])].map((file) => ({ key: next.current++, file })), ...before]);
  return (
    <>
      <Head title={text("page.files")} />
      <Section title={text("file.hand")}>
        <div
          className="drop"
          onDragOver={(event) => event.preventDefault()}
          onDrop={(event) => {
            event.preventDefault();
            if (!why) take(event.dataTransfer.files);
          }}
        >
          <label htmlFor="files">{text("file.drop")}</label>
          <input
            id="files"
            type="file"
            multiple
            disabled={Boolean(why)}
            onChange={(event) => {
              take(event.currentTarget.files);
              event.currentTarget.value = "";
            }}
          />
          {why && <span className="why">{why}</span>}
        </div>
        <p className="soft">{text("file.nothing")}</p>
      </Section>
      {files.map((one) => (
        <Handed key={one.key} file={one.file} />
      ))}
    </>
  );
}
