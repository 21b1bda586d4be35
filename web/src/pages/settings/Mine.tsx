import { NativeSelect, PasswordInput, TextInput, Title } from "@mantine/core";
import { useState, type FormEvent } from "react";

import { nowIs, useChange } from "../../api/asking";
import type { Shape } from "../../api/client";
import { useLanguageSet, useUnitSet } from "../../frame/choices";
import { Act, Refused, Section } from "../../show/parts";
import { useUser } from "../../show/roles";
import { LANGUAGES, useText } from "../../text/text";

const UNITS = ["mm", "inch"] as const;

/** What everybody may change of himself: language, unit of lengths, and password. */
export function Mine() {
  const text = useText();
  const me = useUser();
  const setLanguage = useLanguageSet();
  const setUnit = useUnitSet();
  return (
    <Section title={text("settings.mine")}>
      <div className="fields">
        <NativeSelect
          label={text("head.language")}
          value={document.documentElement.lang}
          onChange={(event) => void setLanguage(event.currentTarget.value)}
          data={LANGUAGES.map((value) => ({ value, label: text(`language.${value}`) }))}
        />
        <NativeSelect
          label={text("settings.unit")}
          description={text("settings.unit.hint")}
          value={me.unit}
          onChange={(event) => void setUnit(event.currentTarget.value as Shape<"Me">["unit"])}
          data={UNITS.map((value) => ({ value, label: text(`unit.${value}`) }))}
        />
      </div>
      <Password />
    </Section>
  );
}

function Password() {
  const text = useText();
  const me = useUser();
  const [present, writePresent] = useState("");
  const [password, write] = useState("");
  const [again, writeAgain] = useState("");
  const change = useChange();
  const why = !present || !password || !again ? text("settings.empty") : password === again ? "" : text("settings.differ");

  function submit(event: FormEvent) {
    event.preventDefault();
    if (why) return;
    const body = { password, present_password: present, language: null } satisfies Shape<"Mine">;
    change.mutate({ method: "PATCH", path: "me", body }, { onSuccess: () => nowIs(null) });
  }
  return (
    <form className="fields" onSubmit={submit} aria-label={text("settings.password")}>
      <Title order={3} size="h5">
        {text("settings.password")}
      </Title>
      <div className="two">
        <TextInput label={text("settings.account.name")} autoComplete="username" value={me.name} readOnly />
        <Secret label={text("settings.present")} complete="current-password" value={present} write={writePresent} />
        <Secret label={text("settings.new")} complete="new-password" value={password} write={write} />
        <Secret label={text("settings.again")} complete="new-password" value={again} write={writeAgain} />
      </div>
      <p className="soft">{text("settings.ends")}</p>
      <Refused problem={change.error} />
      <Act submit label={text("settings.change")} busy={change.isPending} why={why} />
    </form>
  );
}

function Secret({ label, complete, value, write }: { label: string; complete: string; value: string; write: (to: string) => void }) {
  return (
    <PasswordInput label={label} autoComplete={complete} value={value} onChange={(event) => write(event.currentTarget.value)} />
  );
}
