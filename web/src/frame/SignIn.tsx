import { Button, Paper, PasswordInput, TextInput, Title } from "@mantine/core";
import { useMutation } from "@tanstack/react-query";
import { useState, type FormEvent } from "react";

import { nowIs, useShown } from "../api/asking";
import { ask, Problem, type Shape } from "../api/client";
import { Refused } from "../show/parts";
import { useText } from "../text/text";

/** Why one comes back from an identity provider without having been signed in; the service says it by a code. */
function refusedByProvider(): Problem | null {
  const code = new URLSearchParams(window.location.search).get("refused") ?? "";
  return /^SRV-[A-Z]+$/.test(code) ? new Problem(code, "problem.provider", "problem.provider.hint", 401) : null;
}

/** The secret in the link that the service printed as it started, which is sent nowhere but to make the first account. */
const secret = /^#first=([\w-]+)$/.exec(window.location.hash)?.[1] ?? "";

/** Name and password, the first account of a new service, or by an identity provider where there is one. */
export function SignIn() {
  const text = useText();
  const ways = useShown<Shape<"Ways">>("session/ways");
  const [name, setName] = useState("");
  const [password, setPassword] = useState("");
  const first = secret !== "" && ways.data?.accounts === false;
  const signing = useMutation<Shape<"Me">, Problem>({
    mutationFn: () =>
      first
        ? ask("POST", "session/first", { body: { secret, name, password, language: document.documentElement.lang } })
        : ask("POST", "session", { body: { name, password } }),
    onSuccess: (me) => {
      history.replaceState(null, "", window.location.pathname);
      nowIs(me);
    },
  });

  function submit(event: FormEvent) {
    event.preventDefault();
    signing.mutate();
  }
  return (
    <main className="sign-in">
      <Paper withBorder p="lg">
        <Title order={1} size="h2">
          trueloop
        </Title>
        {first && <p>{text("first.why")}</p>}
        {!first && ways.data?.accounts === false && <p>{text("first.link")}</p>}
        <form className="fields" onSubmit={submit} aria-label={text(first ? "first.title" : "sign.title")}>
          <TextInput
            label={text("sign.name")}
            autoComplete="username"
            autoFocus
            value={name}
            onChange={(event) => setName(event.currentTarget.value)}
          />
          <PasswordInput
            label={text("sign.password")}
            autoComplete={first ? "new-password" : "current-password"}
            description={first ? text("first.password") : undefined}
            value={password}
            onChange={(event) => setPassword(event.currentTarget.value)}
          />
          <Refused problem={signing.error ?? refusedByProvider()} />
          <Button type="submit" loading={signing.isPending} disabled={!name || !password}>
            {text(first ? "first.make" : "sign.in")}
          </Button>
          {ways.data?.oidc && (
            <Button component="a" href="/api/v1/session/oidc" variant="default">
              {ways.data.oidc}
            </Button>
          )}
        </form>
      </Paper>
    </main>
  );
}
