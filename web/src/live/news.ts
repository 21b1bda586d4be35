import { client } from "../api/asking";

const AGAIN_MS = 5000;
const TOGETHER_MS = 300;

/** Listens to the service's events until the returned function is called: what is shown is asked anew. */
export function listen(): () => void {
  let due: ReturnType<typeof setTimeout> | undefined;
  let again: ReturnType<typeof setTimeout> | undefined;
  let lost = false;

  function renew(): void {
    due ??= setTimeout(() => {
      due = undefined;
      void client.invalidateQueries();
    }, TOGETHER_MS);
  }
  function heard(what: string): void {
    if (what === "news" || (what === "open" && lost)) renew();
    lost = what === "lost";
    if (lost) {
      clearTimeout(again);
      again = setTimeout(begin, AGAIN_MS);
    }
  }
  const { begin, end } = typeof SharedWorker === "undefined" ? alone(heard) : together(heard);
  begin();
  addEventListener("pagehide", end);
  return () => {
    clearTimeout(due);
    clearTimeout(again);
    removeEventListener("pagehide", end);
    end();
  };
}

function together(heard: (what: string) => void) {
  const worker = new SharedWorker(new URL("./worker.ts", import.meta.url), { type: "module", name: "news" });
  worker.port.onmessage = ({ data }) => heard(String(data));
  return { begin: () => worker.port.postMessage("listen"), end: () => worker.port.postMessage("end") };
}

function alone(heard: (what: string) => void) {
  let source: EventSource | null = null;
  function begin(): void {
    if (source && source.readyState !== EventSource.CLOSED) return;
    source = new EventSource("/api/v1/events");
    source.onopen = () => heard("open");
    source.onmessage = () => heard("news");
    source.onerror = () => heard("lost");
  }
  return { begin, end: () => source?.close() };
}
