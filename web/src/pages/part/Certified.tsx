import { NativeSelect, TextInput } from "@mantine/core";
import { useState } from "react";

import { useChange } from "../../api/asking";
import type { Shape } from "../../api/client";
import { Act, Age, Opens, Refused, Rows, State, useWhyNot } from "../../show/parts";
import { LANGUAGES, useText } from "../../text/text";

type Life = Shape<"PartLife">;
type Wanted = Shape<"CertifyPart">;

/** The certificates of a part, and one more, made from what is known of it now. */
export function Certified({ life }: { life: Life }) {
  const text = useText();
  return (
    <>
      <Rows
        label={text("part.certificates")}
        none={text("certificate.none")}
        head={(["verdict", "at", "by", "open"] as const).map((one) => text(`head.${one}`))}
        rows={life.certificates.map((one) => ({
          key: one.id,
          cells: [
            <State kind="verdict" name={one.verdict} />,
            <Age at={one.made_at} />,
            one.made_by,
            <Opens href={`certificates/${one.id}`}>{text("certificate.open")}</Opens>,
          ],
        }))}
      />
      {life.inspections.length > 0 && <Make part={life.part.id} />}
    </>
  );
}

function Make({ part }: { part: number }) {
  const text = useText();
  const whyNot = useWhyNot();
  const [language, speak] = useState(document.documentElement.lang as Wanted["language"]);
  const [u, write] = useState("");
  const making = useChange();
  const u_um = u.trim() ? Number(u.replace(",", ".")) : null;
  return (
    <div className="fields">
      <div className="two">
        <NativeSelect
          label={text("certificate.language")}
          value={language}
          onChange={(event) => speak(event.currentTarget.value as Wanted["language"])}
          data={LANGUAGES.map((value) => ({ value, label: text(`language.${value}`) }))}
        />
        <TextInput
          label={text("certificate.u")}
          inputMode="decimal"
          value={u}
          onChange={(event) => write(event.currentTarget.value)}
        />
      </div>
      <Refused problem={making.error} />
      <Act
        label={text("certificate.make")}
        busy={making.isPending}
        why={whyNot("engineer") || (u_um === null || u_um > 0 ? "" : text("certificate.u.wrong"))}
        onClick={() => making.mutate({ path: "certificates", body: { part, language, u_um } satisfies Wanted })}
      />
    </div>
  );
}
