import { createContext, useContext } from "react";

import type { Shape } from "../api/client";

export type Role = "viewer" | "operator" | "engineer" | "admin";
export const ROLES: readonly Role[] = ["viewer", "operator", "engineer", "admin"];

/** Whether a role may do what needs another; the service judges it once more. */
export function may(mine: string, needed: string): boolean {
  return ROLES.indexOf(mine as Role) >= ROLES.indexOf(needed as Role);
}

export const MeContext = createContext<Shape<"Me"> | null>(null);

/** Who is signed in. */
export function useUser(): Shape<"Me"> {
  const me = useContext(MeContext);
  if (!me) throw new Error("nobody is signed in");
  return me;
}
