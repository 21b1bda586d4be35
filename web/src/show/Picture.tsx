import { useComputedColorScheme } from "@mantine/core";

import { useReader } from "./lengths";

const NARROW = "(max-width: 40rem)";

/** A picture (SVG) of the service, as the page is light or dark and, where it has both, wide or narrow. `said` is what it
 * shows in words: a reader who sees no picture is told the same. */
export function Picture({ path, said, sizes = false }: { path: string; said: string; sizes?: boolean }) {
  const dark = useComputedColorScheme("light") === "dark";
  const at = `/api/v1/${path}?${useReader()}&dark=${dark}`;
  return (
    <picture>
      {sizes && <source media={NARROW} srcSet={`${at}&narrow=true`} />}
      <img className={sizes ? "picture" : "picture small"} src={at} alt={said} loading="lazy" />
    </picture>
  );
}
