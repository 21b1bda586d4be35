import { lazy, type ComponentType } from "react";

import type { Key } from "../text/text";

/** A page with an entry of its own. */
export type Entry = { href: string; name: Key };

/** The entries of the menu, in its order, each with the pages of its section: the first is the one that it leads to. */
export const SECTIONS: [Entry, ...Entry[]][] = [
  [
    { href: "/", name: "page.today" },
    { href: "/alarms", name: "page.alarms" },
    { href: "/wall", name: "page.wall" },
  ],
  [
    { href: "/machines", name: "page.machines" },
    { href: "/tools", name: "page.tools" },
  ],
  [{ href: "/orders", name: "page.orders" }],
  [
    { href: "/parts", name: "page.parts" },
    { href: "/certificates", name: "page.certificates" },
  ],
  [
    { href: "/series", name: "page.series" },
    { href: "/proposals", name: "page.proposals" },
    { href: "/diagnosis", name: "page.diagnosis" },
  ],
  [
    { href: "/correct", name: "page.correct" },
    { href: "/programs", name: "page.programs" },
    { href: "/files", name: "page.files" },
  ],
  [{ href: "/settings", name: "page.settings" }],
];

/** Whether a place of the service belongs to a page of the menu. */
export function leadsTo(page: Entry, place: string): boolean {
  return place === page.href || (page.href !== "/" && place.startsWith(`${page.href}/`));
}

const Today = lazy(() => import("../pages/Today"));
const Orders = lazy(() => import("../pages/OrderPage").then(({ Orders }) => ({ default: Orders })));
const Plan = lazy(() => import("../pages/Plan"));
const OrderPage = lazy(() => import("../pages/OrderPage"));
const Parts = lazy(() => import("../pages/PartLife").then(({ Parts }) => ({ default: Parts })));
const PartLife = lazy(() => import("../pages/PartLife"));
const Proposals = lazy(() => import("../pages/Proposals"));
const Certificates = lazy(() => import("../pages/Certificates"));
const Alarms = lazy(() => import("../pages/Alarms"));
const Settings = lazy(() => import("../pages/Settings"));
const Series = lazy(() => import("../pages/SeriesPage").then(({ Series }) => ({ default: Series })));
const SeriesPage = lazy(() => import("../pages/SeriesPage"));
const Tools = lazy(() => import("../pages/ToolPage").then(({ Tools }) => ({ default: Tools })));
const ToolPage = lazy(() => import("../pages/ToolPage"));
const Machines = lazy(() => import("../pages/MachinePage").then(({ Machines }) => ({ default: Machines })));
const MachinePage = lazy(() => import("../pages/MachinePage"));
const Charts = lazy(() => import("../pages/Charts"));
const Diagnosis = lazy(() => import("../pages/Diagnosis"));
const OfSeries = lazy(() => import("../pages/diagnosis/OfSeries"));
const OfPart = lazy(() => import("../pages/diagnosis/OfPart"));
const Wall = lazy(() => import("../pages/Wall"));
const Programs = lazy(() => import("../pages/Programs"));
const Correct = lazy(() => import("../pages/Correct"));
const Files = lazy(() => import("../pages/Files"));
const Diff = lazy(() => import("../pages/Diff"));

/** What is shown at which address. */
export const ROUTES: { path: string; page: ComponentType<{ id: string; of: string }> }[] = [
  { path: "/", page: Today },
  { path: "/orders", page: Orders },
  { path: "/orders/new", page: Plan },
  { path: "/orders/:id", page: OrderPage },
  { path: "/parts", page: Parts },
  { path: "/parts/:id", page: PartLife },
  { path: "/proposals", page: Proposals },
  { path: "/proposals/:id", page: Proposals },
  { path: "/certificates", page: Certificates },
  { path: "/alarms", page: Alarms },
  { path: "/machines", page: Machines },
  { path: "/machines/:id", page: MachinePage },
  { path: "/series", page: Series },
  { path: "/series/:of/:id", page: SeriesPage },
  { path: "/charts/:of/:id", page: Charts },
  { path: "/diagnosis", page: Diagnosis },
  { path: "/diagnosis/:id", page: OfSeries },
  { path: "/diagnosis/:of/parts/:id", page: OfPart },
  { path: "/tools", page: Tools },
  { path: "/tools/:id", page: ToolPage },
  { path: "/settings", page: Settings },
  { path: "/wall", page: Wall },
  { path: "/programs", page: Programs },
  { path: "/correct", page: Correct },
  { path: "/files", page: Files },
  { path: "/programs/:of/diff/:id", page: Diff },
];
