import { lazy, type ComponentType } from "react";

import type { Key } from "../text/text";

/** The pages of the menu, in its order. */
export const PAGES: { href: string; name: Key }[] = [
  { href: "/", name: "page.today" },
  { href: "/machines", name: "page.machines" },
  { href: "/orders", name: "page.orders" },
  { href: "/parts", name: "page.parts" },
  { href: "/series", name: "page.series" },
  { href: "/diagnosis", name: "page.diagnosis" },
  { href: "/tools", name: "page.tools" },
  { href: "/programs", name: "page.programs" },
  { href: "/files", name: "page.files" },
  { href: "/proposals", name: "page.proposals" },
  { href: "/certificates", name: "page.certificates" },
  { href: "/alarms", name: "page.alarms" },
  { href: "/settings", name: "page.settings" },
  { href: "/wall", name: "page.wall" },
];

const Today = lazy(() => import("../pages/Today"));
const Orders = lazy(() => import("../pages/Orders"));
const Plan = lazy(() => import("../pages/Plan"));
const OrderPage = lazy(() => import("../pages/OrderPage"));
const Parts = lazy(() => import("../pages/Parts"));
const PartLife = lazy(() => import("../pages/PartLife"));
const Proposals = lazy(() => import("../pages/Proposals"));
const Certificates = lazy(() => import("../pages/Certificates"));
const Alarms = lazy(() => import("../pages/Alarms"));
const Settings = lazy(() => import("../pages/Settings"));
const Series = lazy(() => import("../pages/Series"));
const SeriesPage = lazy(() => import("../pages/SeriesPage"));
const Tools = lazy(() => import("../pages/Tools"));
const ToolPage = lazy(() => import("../pages/ToolPage"));
const Machines = lazy(() => import("../pages/Machines"));
const MachinePage = lazy(() => import("../pages/MachinePage"));
const Charts = lazy(() => import("../pages/Charts"));
const Diagnosis = lazy(() => import("../pages/Diagnosis"));
const OfSeries = lazy(() => import("../pages/diagnosis/OfSeries"));
const OfPart = lazy(() => import("../pages/diagnosis/OfPart"));
const Wall = lazy(() => import("../pages/Wall"));
const Programs = lazy(() => import("../pages/Programs"));
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
  { path: "/files", page: Files },
  { path: "/programs/:of/diff/:id", page: Diff },
];
