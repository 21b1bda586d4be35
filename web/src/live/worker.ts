// One connection to the service's events for all windows of a browser, which may open only six to one host.
interface Worker {
  onconnect: (event: MessageEvent) => void;
}

const ports = new Set<MessagePort>();
let source: EventSource | null = null;

function tell(what: string): void {
  for (const port of ports) port.postMessage(what);
}

function open(): void {
  if (source && source.readyState !== EventSource.CLOSED) return;
  source = new EventSource("/api/v1/events");
  source.onopen = () => tell("open");
  source.onmessage = () => tell("news");
  source.onerror = () => tell("lost");
}

(self as unknown as Worker).onconnect = (event) => {
  const port = event.ports[0];
  if (!port) return;
  ports.add(port);
  port.onmessage = ({ data }) => {
    if (data === "listen") open();
    if (data === "end") ports.delete(port);
    if (ports.size === 0) {
      source?.close();
      source = null;
    }
  };
};
