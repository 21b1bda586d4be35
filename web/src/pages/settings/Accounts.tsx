import { NativeSelect, PasswordInput, TextInput, Title } from "@mantine/core";
import { useState, type FormEvent } from "react";

import { useChange, useShown } from "../../api/asking";
import type { Shape } from "../../api/client";
import { Act, Age, Refused, Rows, Section, Shown, State } from "../../show/parts";
import { ROLES } from "../../show/roles";
import { LANGUAGES, useName, useText } from "../../text/text";

type Account = Shape<"AccountRow">;
const HEADS = ["account", "name", "role", "language", "state", "since"] as const;

/** All accounts; an administrator adds and changes them. */
export function Accounts() {
  const text = useText();
  const found = useShown<Shape<"Accounts">>("accounts");
  return (
    <Section title={text("settings.accounts")}>
      <Shown found={found}>
        {({ items }) => (
          <>
            <Listed accounts={items} />
            <Changed accounts={items} />
          </>
        )}
      </Shown>
      <Added />
    </Section>
  );
}

function Listed({ accounts }: { accounts: Account[] }) {
  const text = useText();
  const word = useName();
  return (
    <Rows
      label={text("settings.accounts")}
      none={text("settings.accounts.none")}
      head={HEADS.map((one) => text(`head.${one}`))}
      rows={accounts.map((one) => ({
        key: one.name,
        look: one.disabled ? "stale" : "",
        cells: [
          one.name,
          one.display,
          word("role", one.role),
          word("language", one.language),
          <State kind="account" name={one.disabled ? "disabled" : "active"} />,
          <Age at={one.made_at} />,
        ],
      }))}
    />
  );
}

function Changed({ accounts }: { accounts: Account[] }) {
  const text = useText();
  const [name, choose] = useState("");
  const one = accounts.find((account) => account.name === name);
  return (
    <div className="fields">
      <Title order={3} size="h5">
        {text("settings.account.change")}
      </Title>
      <NativeSelect
        label={text("head.account")}
        value={name}
        onChange={(event) => choose(event.currentTarget.value)}
        data={["", ...accounts.map((account) => account.name)]}
      />
      {one && <Change key={`${one.name} ${one.etag}`} one={one} />}
    </div>
  );
}

function Change({ one }: { one: Account }) {
  const text = useText();
  const [role, setRole] = useState<string>(one.role);
  const [state, setState] = useState(one.disabled ? "disabled" : "active");
  const [password, write] = useState("");
  const change = useChange();
  const body = {
    role: role === one.role ? null : (role as Account["role"]),
    disabled: (state === "disabled") === one.disabled ? null : state === "disabled",
    password: password || null,
    language: null,
  } satisfies Shape<"Change">;
  const same = body.role === null && body.disabled === null && body.password === null;

  function submit(event: FormEvent) {
    event.preventDefault();
    if (same) return;
    change.mutate({ method: "PATCH", path: `accounts/${encodeURIComponent(one.name)}`, etag: one.etag, body });
  }
  return (
    <form className="fields" onSubmit={submit} aria-label={text("settings.account.change")}>
      <div className="two">
        <TextInput label={text("settings.account.name")} autoComplete="username" value={one.name} readOnly />
        <RoleChoice value={role} choose={setRole} />
        <NativeSelect
          label={text("head.state")}
          value={state}
          onChange={(event) => setState(event.currentTarget.value)}
          data={(["active", "disabled"] as const).map((value) => ({ value, label: text(`account.${value}`) }))}
        />
        <PasswordInput
          label={text("settings.password.other")}
          autoComplete="new-password"
          value={password}
          onChange={(event) => write(event.currentTarget.value)}
        />
      </div>
      <p className="soft">{text("settings.account.ends")}</p>
      <Refused problem={change.error} />
      <Act
        submit
        label={text("settings.account.change")}
        busy={change.isPending}
        why={same ? text("settings.account.same") : ""}
      />
    </form>
  );
}

function Added() {
  const text = useText();
  const [name, setName] = useState("");
  const [display, setDisplay] = useState("");
  const [role, setRole] = useState("viewer");
  const [language, setLanguage] = useState<string>(document.documentElement.lang);
  const [password, write] = useState("");
  const adding = useChange();
  const body = { name: name.trim(), display: display.trim(), role: role as Account["role"], language, password };
  const empty = body.name && password ? "" : text("settings.empty");

  function submit(event: FormEvent) {
    event.preventDefault();
    if (empty) return;
    adding.mutate({ path: "accounts", body }, { onSuccess: () => [setName, setDisplay, write].forEach((one) => one("")) });
  }
  return (
    <form className="fields" onSubmit={submit} aria-label={text("settings.account.add")}>
      <Title order={3} size="h5">
        {text("settings.account.add")}
      </Title>
      <div className="two">
        <TextInput
          label={text("settings.account.name")}
          autoComplete="username"
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
        />
        <TextInput
          label={text("settings.display")}
          autoComplete="off"
          value={display}
          onChange={(event) => setDisplay(event.currentTarget.value)}
        />
        <RoleChoice value={role} choose={setRole} />
        <NativeSelect
          label={text("head.language")}
          value={language}
          onChange={(event) => setLanguage(event.currentTarget.value)}
          data={LANGUAGES.map((value) => ({ value, label: text(`language.${value}`) }))}
        />
        <PasswordInput
          label={text("settings.password.first")}
          autoComplete="new-password"
          value={password}
          onChange={(event) => write(event.currentTarget.value)}
        />
      </div>
      <Refused problem={adding.error} />
      <Act submit label={text("settings.account.add")} busy={adding.isPending} why={empty} />
    </form>
  );
}

function RoleChoice({ value, choose }: { value: string; choose: (role: string) => void }) {
  const text = useText();
  return (
    <NativeSelect
      label={text("head.role")}
      value={value}
      onChange={(event) => choose(event.currentTarget.value)}
      data={ROLES.map((role) => ({ value: role, label: text(`role.${role}`) }))}
    />
  );
}
