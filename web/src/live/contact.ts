import { useEffect, useSyncExternalStore } from "react";

const EVERY_MS = 4000;
const LOST_MS = 10_000;

/** When the service last answered, and whether that is too long ago. */
export interface Contact {
  at: number;
  now: number;
  lost: boolean;
}

let state: Contact = { at: Date.now(), now: Date.now(), lost: false };
const told = new Set<() => void>();

function set(at: number): void {
  const now = Date.now();
  state = { at, now, lost: now - at > LOST_MS };
  document.documentElement.toggleAttribute("data-lost", state.lost);
  for (const one of told) one();
}

async function look(): Promise<void> {
  try {
    const answer = await fetch("/healthz", { signal: AbortSignal.timeout(EVERY_MS), cache: "no-store" });
    if (answer.ok) set(Date.now());
  } catch {
    // the clock that turns says how long it is silent
  }
}

/** Asks again and again whether the service is there; used once, by the frame. */
export function useContactKept(): void {
  useEffect(() => {
    void look();
    const asking = setInterval(() => void look(), EVERY_MS);
    const turning = setInterval(() => set(state.at), 1000);
    return () => {
      clearInterval(asking);
      clearInterval(turning);
    };
  }, []);
}

function subscribe(one: () => void): () => void {
  told.add(one);
  return () => told.delete(one);
}

/** The state of contact, renewed every second: by it ages are shown. */
export function useContact(): Contact {
  return useSyncExternalStore(subscribe, () => state);
}
