import { AppShell, Burger, Button, NavLink, Text, useComputedColorScheme, useMantineColorScheme } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useEffect, type ReactNode } from "react";
import { Link, useLocation } from "wouter";

import { nowIs } from "../api/asking";
import { ask } from "../api/client";
import { useContact } from "../live/contact";
import { ago, moment } from "../show/format";
import { useUser } from "../show/roles";
import { useName, useText } from "../text/text";
import { useLanguageSet, useUnitSet } from "./choices";
import { leadsTo, SECTIONS, type Entry } from "./routes";

/** The frame around every page: where one is, who one is, and whether what is seen is live. */
export function Shell({ children }: { children: ReactNode }) {
  const text = useText();
  const [open, menu] = useDisclosure(false);
  const [place] = useLocation();
  useEffect(() => menu.close(), [place]);
  const section = SECTIONS.find((pages) => pages.some((page) => leadsTo(page, place)));
  return (
    <AppShell
      header={{ height: 64 }}
      navbar={{ width: 220, breakpoint: "md", collapsed: { mobile: !open } }}
      padding="md"
      transitionDuration={0}
    >
      <AppShell.Header px="md" style={{ display: "flex", alignItems: "center", gap: "1rem" }}>
        <a className="skip" href="#content">
          {text("skip")}
        </a>
        <Burger
          opened={open}
          onClick={menu.toggle}
          hiddenFrom="md"
          size="lg"
          aria-label={text("frame.menu")}
          aria-expanded={open}
        />
        <Text fw={700} visibleFrom="md">
          trueloop
        </Text>
        <ContactShown />
      </AppShell.Header>
      <AppShell.Navbar p="xs" aria-label={text("frame.pages")} style={{ overflowY: "auto" }}>
        {SECTIONS.map((pages) => (
          <NavLink
            key={pages[0].href}
            component={Link}
            href={pages[0].href}
            label={text(pages[0].name)}
            active={pages === section}
            {...(place === pages[0].href ? { "aria-current": "page" as const } : {})}
          />
        ))}
        <Mine />
      </AppShell.Navbar>
      <AppShell.Main id="content" tabIndex={-1}>
        {section && section.length > 1 && <SectionPages pages={section} place={place} />}
        <div className="page">{children}</div>
      </AppShell.Main>
    </AppShell>
  );
}

/** The pages of the section, beside each other above the page itself. */
function SectionPages({ pages, place }: { pages: [Entry, ...Entry[]]; place: string }) {
  const text = useText();
  return (
    <nav className="section" aria-label={text(pages[0].name)}>
      {pages.map((page) => (
        <Link key={page.href} href={page.href} aria-current={leadsTo(page, place) ? "page" : undefined}>
          {text(page.name)}
        </Link>
      ))}
    </nav>
  );
}

/** Whether the service answers, and of when the values are. */
export function ContactShown() {
  const { at, now, lost } = useContact();
  const text = useText();
  return (
    <span className={lost ? "contact lost" : "contact"} role="status" aria-live="off">
      {lost
        ? text("contact.lost", { age: ago(now - at), at: moment(at) })
        : text("contact.live", { at: moment(at) })}
    </span>
  );
}

function Mine() {
  const me = useUser();
  const text = useText();
  const word = useName();
  const colours = useMantineColorScheme();
  const dark = useComputedColorScheme("light") === "dark";
  const german = document.documentElement.lang === "de";
  const setLanguage = useLanguageSet();
  const setUnit = useUnitSet();
  const other = me.unit === "mm" ? "inch" : "mm";

  async function leave() {
    try {
      await ask("DELETE", "session");
    } finally {
      nowIs(null);
    }
  }
  return (
    <div className="mine">
      <Text size="sm" fw={600}>
        {me.display || me.name}
      </Text>
      <Text size="sm" className="soft">
        {word("role", me.role)}
      </Text>
      <Button variant="default" fullWidth onClick={() => colours.setColorScheme(dark ? "light" : "dark")}>
        {text(dark ? "frame.light" : "frame.dark")}
      </Button>
      <Button variant="default" fullWidth onClick={() => void setLanguage(german ? "en" : "de")} lang={german ? "en" : "de"}>
        {text("frame.language")}
      </Button>
      <Button variant="default" fullWidth onClick={() => void setUnit(other)}>
        {text(`frame.${other}`)}
      </Button>
      <Button variant="default" fullWidth onClick={() => void leave()}>
        {text("sign.out")}
      </Button>
    </div>
  );
}
