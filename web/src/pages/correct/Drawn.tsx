import type { Shape } from "../../api/client";

/** A picture that came with an answer, on white as in the report. */
export function Drawn({ of }: { of: Shape<"Picture"> }) {
  const at = (svg: string) => `data:image/svg+xml,${encodeURIComponent(svg)}`;
  return (
    <picture>
      <source media="(max-width: 40rem)" srcSet={at(of.narrow)} />
      <img className="picture drawn" src={at(of.wide)} alt={of.said} />
    </picture>
  );
}
