import {
  QueryClient,
  useInfiniteQuery,
  useMutation,
  useQuery,
  useQueryClient,
  type UseMutationResult,
} from "@tanstack/react-query";
import { useRef } from "react";

import { ask, Problem, type Given, type Shape } from "./client";

export const client = new QueryClient({
  defaultOptions: {
    queries: {
      staleTime: 1000,
      retry: (count, error) => error instanceof Problem && error.status === 0 && count < 1,
      refetchOnWindowFocus: true,
    },
  },
});

/** What stands at an address; asked anew when something has happened, and every so many seconds. */
export function useShown<T>(path: string, every_s = 0) {
  return useQuery<T, Problem>({
    queryKey: [path],
    queryFn: ({ signal }) => ask<T>("GET", path, { signal }),
    refetchInterval: every_s > 0 ? every_s * 1000 : false,
  });
}

interface PageOf<T> {
  items: T[];
  next: string | null;
}

/** A list page by page; `path` with what it is asked for. */
export function usePages<T>(path: string) {
  const sign = path.includes("?") ? "&" : "?";
  return useInfiniteQuery<PageOf<T>, Problem, T[], string[], string>({
    queryKey: [path],
    initialPageParam: "",
    queryFn: ({ pageParam, signal }) =>
      ask<PageOf<T>>("GET", pageParam ? `${path}${sign}cursor=${encodeURIComponent(pageParam)}` : path, { signal }),
    getNextPageParam: (last) => last.next,
    select: (found) => found.pages.flatMap((page) => page.items),
  });
}

export interface Change extends Given {
  method?: string;
  path: string;
}

/** A change. What was not answered is sent again under the same key: it is done once. */
export function useChange<T = unknown>(): UseMutationResult<T, Problem, Change> {
  const all = useQueryClient();
  const open = useRef("");
  return useMutation<T, Problem, Change>({
    mutationFn: async ({ method = "POST", path, ...given }) => {
      open.current ||= crypto.randomUUID();
      try {
        const done = await ask<T>(method, path, method === "POST" ? { once: open.current, ...given } : given);
        open.current = "";
        return done;
      } catch (error) {
        if (error instanceof Problem && error.status !== 0) open.current = "";
        throw error;
      }
    },
    onSettled: () => all.invalidateQueries(),
  });
}

/** Who is signed in; undefined while that is being asked. */
export function useMe() {
  return useQuery<Shape<"Me"> | null, Problem>({
    queryKey: ["me"],
    queryFn: async () => {
      try {
        return await ask<Shape<"Me">>("GET", "me");
      } catch (error) {
        if (error instanceof Problem && error.status === 401) return null;
        throw error;
      }
    },
  });
}

/** Somebody else is signed in now, or nobody: what the one before was shown is forgotten. */
export function nowIs(me: Shape<"Me"> | null): void {
  client.setQueryData(["me"], me);
  client.removeQueries({ predicate: ({ queryKey }) => queryKey[0] !== "me" });
}
