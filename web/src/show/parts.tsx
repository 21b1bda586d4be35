import { Alert, Button, Loader, Paper, Text, TextInput, Title } from "@mantine/core";
import type { ReactNode } from "react";
import { Link } from "wouter";

import { Problem } from "../api/client";
import { useContact } from "../live/contact";
import { useHint, useName, useText, type Key } from "../text/text";
import { ago, moment } from "./format";
import { textIn, type Given, type TypedLength } from "./length";
import { useLengths } from "./lengths";
import { may, useUser, type Role } from "./roles";

/** Why something was refused: what, the code to look it up by, and what to do. */
export function Refused({ problem }: { problem: Problem | null | undefined }) {
  const text = useText();
  const hinted = useHint();
  if (!problem) return null;
  const own = problem.message.startsWith("problem.");
  const hint = problem.hint.startsWith("problem.") ? text(problem.hint as Key) : hinted(problem);
  return (
    <Alert className="refused" role="alert" variant="default" title={own ? text(problem.message as Key) : problem.message}>
      <Text size="sm">
        {problem.code && <code>{problem.code}</code>} {hint}
      </Text>
    </Alert>
  );
}

/** When a value is of, and how old it is; grey when that is too old. */
export function Age({ at, stale = false }: { at: string | number | null | undefined; stale?: boolean }) {
  const { now } = useContact();
  const text = useText();
  if (at === null || at === undefined || at === "") return <span className="age stale">{text("age.never")}</span>;
  const time = new Date(at).getTime();
  return (
    <span className={stale ? "age stale" : "age"}>
      {moment(at)} · {text("age.ago", { age: ago(now - time) })}
    </span>
  );
}

const GOOD = ["recorded", "released", "accepted", "done", "in", "ran"];
const BAD = ["held", "rejected", "unknown", "failed", "out"];
const BUSY = ["started", "sent", "verified", "offered", "ended", "running", "open"];

/** A state as a word in its colour: the word says it too. */
export function State({ kind, name }: { kind: string; name: string | null | undefined }) {
  const word = useName();
  if (!name) return <span className="state">–</span>;
  const look = GOOD.includes(name) ? "good" : BAD.includes(name) ? "bad" : BUSY.includes(name) ? "busy" : "plain";
  return <span className={`state ${look}`}>{word(kind, name)}</span>;
}

const SAME = ["read back", "there already", "fetched", "the same"];

/** What came of a transfer: as it should in green, refused or different in red with what the record says of it. */
export function Outcome({ said }: { said: string }) {
  const word = useName();
  if (SAME.includes(said)) return <span className="state good">{word("outcome", said)}</span>;
  return /^(differs|[A-Z]{3}-[A-Z]+):/.test(said) ? <span className="why">{said}</span> : <>{said}</>;
}

/** An error along the outward normal, given in µm: red where material is left on, blue where too much was taken. */
export function Deviation({ um, digits = 1 }: { um: number | null | undefined; digits?: number }) {
  const shown = useLengths().signed("um", um, digits);
  const look = shown.startsWith("+") ? "left-on" : shown.startsWith("−") ? "taken" : "";
  return <span className={`number ${look}`}>{shown}</span>;
}

/** Actual less nominal size, given in µm. It has no colour: more than the nominal size is left on a shaft, taken in a bore. */
export function SizeDeviation({ um }: { um: number | null | undefined }) {
  return <span className="number">{useLengths().signed("um", um)}</span>;
}

/** A length without a sign, of a column whose head names the unit. */
export function Length({ of, value, digits }: { of: Given; value: number | null | undefined; digits?: number }) {
  return <span className="number">{useLengths().plain(of, value, digits)}</span>;
}

/** A field for a length in the reader's unit; another choice of the unit converts what was typed. */
export function LengthInput({ of, length, change, ...field }: OfLengthInput) {
  const { unit } = useLengths();
  return <TextInput inputMode="decimal" {...field} value={textIn(unit, of, length)} onChange={(event) => change({ text: event.currentTarget.value, unit })} />;
}

interface OfLengthInput {
  label: string;
  of: Given;
  length: TypedLength;
  change: (length: TypedLength) => void;
  error?: string | false;
  required?: boolean;
}

/** Sentences about how something was read or decided. */
export function Notes({ of }: { of: string[] }) {
  if (of.length === 0) return null;
  return (
    <ul className="remarks">
      {of.map((one) => (
        <li key={one}>{one}</li>
      ))}
    </ul>
  );
}

/** What the colours of deviations mean. */
export function Legend() {
  const text = useText();
  return (
    <ul className="key">
      <li className="left-on">{text("key.left")}</li>
      <li className="taken">{text("key.taken")}</li>
    </ul>
  );
}

/** A part of a page with its heading. */
export function Section({ title, children, side }: { title: string; children: ReactNode; side?: ReactNode }) {
  return (
    <Paper component="section" withBorder p="md" aria-label={title}>
      <div className="section-head">
        <Title order={2} size="h4">
          {title}
        </Title>
        {side}
      </div>
      {children}
    </Paper>
  );
}

/** What an address answered, or why not; what was there before stays, and says of when it is. */
export function Shown<T>({
  found,
  children,
}: {
  found: { data: T | undefined; error: Problem | null; dataUpdatedAt: number };
  children: (data: T) => ReactNode;
}) {
  const text = useText();
  return (
    <>
      {found.error && (found.data === undefined || found.error.status !== 0) && <Refused problem={found.error} />}
      {found.data === undefined && !found.error && <Loader aria-label={text("loading")} />}
      {found.data !== undefined && children(found.data)}
    </>
  );
}

/** A table; on a narrow screen each row is a card. The first cell names the row. */
export function Rows({ head, rows, none, label }: { head: string[]; rows: Row[]; none: string; label: string }) {
  if (rows.length === 0) return <Text className="none">{none}</Text>;
  return (
    <table className="rows" aria-label={label}>
      <thead>
        <tr>
          {head.map((one, k) => (
            <th key={k} scope="col">
              {one}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map(({ key, cells, look }) => (
          <tr key={key} className={look ?? ""}>
            {cells.map((cell, k) => (
              <td key={k} data-label={head[k]}>
                <div>{cell}</div>
              </td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

export interface Row {
  key: string | number;
  cells: ReactNode[];
  look?: string;
}

/** The rest of a list. */
export function More({ list }: { list: { hasNextPage: boolean; isFetchingNextPage: boolean; fetchNextPage: () => unknown } }) {
  const text = useText();
  if (!list.hasNextPage) return null;
  return (
    <Button variant="default" mt="md" loading={list.isFetchingNextPage} onClick={() => list.fetchNextPage()}>
      {text("more")}
    </Button>
  );
}

/** Why this user may not do that; empty where he may. */
export function useWhyNot() {
  const me = useUser();
  const text = useText();
  const word = useName();
  return (needs: Role) =>
    may(me.role, needs) ? "" : text("act.role", { needed: word("role", needs), role: word("role", me.role) });
}

/** A button that says below itself why it cannot be pressed. */
export function Act({ label, why, busy, onClick, danger, plain, submit }: ActProps) {
  return (
    <div className="act">
      <Button
        type={submit ? "submit" : "button"}
        disabled={Boolean(why)}
        loading={busy ?? false}
        variant={danger ? "outline" : plain ? "default" : "filled"}
        {...(danger ? { color: "red" } : {})}
        onClick={onClick}
      >
        {label}
      </Button>
      {why && <span className="why">{why}</span>}
    </div>
  );
}

interface ActProps {
  label: string;
  why?: string;
  busy?: boolean;
  onClick?: () => void;
  danger?: boolean;
  /** Beside the act that the page is for. */
  plain?: boolean;
  submit?: boolean;
}

/** A way to another page. */
export function To({ href, children }: { href: string; children: ReactNode }) {
  return (
    <Link className="to" href={href}>
      {children}
    </Link>
  );
}

/** A report or a file of the service, in a window of its own: it has no way to this one. */
export function Opens({ href, children }: { href: string; children: ReactNode }) {
  return (
    <a className="to" href={`/api/v1/${href}`} target="_blank" rel="noopener noreferrer">
      {children} ↗
    </a>
  );
}

/** The name of a page, with what belongs beside it. */
export function Head({ title, children }: { title: string; children?: ReactNode }) {
  return (
    <div className="page-head">
      <Title order={1} size="h2">
        {title}
      </Title>
      {children}
    </div>
  );
}
