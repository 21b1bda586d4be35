import type { components } from "./shapes";

/** A shape of the service's interface, by its name there. */
export type Shape<Name extends keyof components["schemas"]> = components["schemas"][Name];

/** What the service refuses, with its code and what to do about it. */
export class Problem extends Error {
  constructor(
    readonly code: string,
    message: string,
    readonly hint: string,
    readonly status: number,
  ) {
    super(message);
  }
}

/** What a change carries: `once` is the same when the same thing is tried again. */
export interface Given {
  body?: unknown;
  file?: Blob;
  etag?: string;
  once?: string;
  signal?: AbortSignal;
}

const API = "/api/v1";
const IDLE_MS = 60_000;
let touchedAt = Date.now();
for (const kind of ["pointerdown", "keydown"]) {
  addEventListener(kind, () => (touchedAt = Date.now()), { capture: true, passive: true });
}

/** Nobody has touched the page for a while: what it asks by itself does not keep the session open. */
function lookingOn(): boolean {
  return Date.now() - touchedAt > IDLE_MS && location.pathname !== "/wall";
}

/** One request. Throws a Problem, also where the service does not answer. */
export async function ask<T>(method: string, path: string, given: Given = {}): Promise<T> {
  const answer = await send(method, path, given);
  if (!answer.ok) throw await problemOf(answer);
  const said = await answer.text();
  if (!said) return undefined as T; // also what is said once only, when it is asked for again
  return (answer.headers.get("content-type")?.includes("json") ? JSON.parse(said) : said) as T;
}

async function send(method: string, path: string, { body, file, etag, once, signal }: Given): Promise<Response> {
  const headers: Record<string, string> = { "Accept-Language": document.documentElement.lang };
  if (body !== undefined) headers["Content-Type"] = "application/json";
  if (etag !== undefined) headers["If-Match"] = `"${etag}"`;
  if (once !== undefined) headers["Idempotency-Key"] = once;
  if (method === "GET" && lookingOn()) headers["Looking-On"] = "1";
  try {
    return await fetch(`${API}/${path}`, {
      method,
      headers,
      body: file ?? (body === undefined ? null : JSON.stringify(body)),
      signal: signal ?? null,
    });
  } catch (error) {
    if (signal?.aborted) throw error;
    throw new Problem("", "problem.silent", "problem.silent.hint", 0);
  }
}

async function problemOf(answer: Response): Promise<Problem> {
  try {
    const said = (await answer.json()) as { code: string; detail: string; hint: string };
    return new Problem(said.code, said.detail, said.hint, answer.status);
  } catch {
    return new Problem("", `HTTP ${answer.status}`, "problem.silent.hint", answer.status);
  }
}

/** A part of an address, for a name that may hold any letter. */
export const piece = encodeURIComponent;
