"""What stands around the content of every page: the head, the lists of pages and sections, the search."""

from collections.abc import Sequence
from html import escape

from scripts.manual.contents import Group, Page
from scripts.manual.markdown import Heading


def document(title: str, body: str, script: str = "manual.js", language: str = "en") -> str:
    """A whole page. All that it loads stands beside it."""
    scripts = "".join(f'<script src="{name}" defer></script>\n' for name in script.split())
    return f"""<!doctype html>
<html lang="{language}">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{escape(title)}</title>
<link rel="stylesheet" href="manual.css">
<link rel="icon" href="icon.svg">
{scripts}</head>
<body>
<a class="skip" href="#content">To the content</a>
<header>
<a class="home" href="index.html">trueloop</a>
<form role="search" action="search.html">
<input type="search" name="q" placeholder="Search the manual" aria-label="Search the manual" autocomplete="off">
<button>Search</button>
</form>
</header>
{body}</body>
</html>
"""


def page(current: Page, content: str, headings: Sequence[Heading], all_groups: Sequence[Group]) -> str:
    """A page of the manual."""
    title = next((one.text for one in headings if one.level == 1), current.title)
    body = (
        f'<div class="frame">\n{contents(current, all_groups)}'
        f'<main id="content" tabindex="-1">\n{content}{neighbours(current, all_groups)}</main>\n'
        f"{sections(headings)}</div>\n"
    )
    return document(title if current.title == "Manual" else f"{title} · trueloop", body, language=current.language)


def contents(current: Page | None, all_groups: Sequence[Group]) -> str:
    """All pages, by kind of reader; the group of the current page is open."""
    parts = [_group(group, current) for group in all_groups]
    return (
        '<nav class="pages" aria-label="Pages"><details class="all" open><summary>All pages</summary>\n'
        f"{''.join(parts)}</details></nav>\n"
    )


def _group(group: Group, current: Page | None) -> str:
    items = "".join(
        f'<li><a href="{one.address}"{" aria-current=page" if one == current else ""}>{escape(one.title)}</a></li>\n'
        for one in group.pages
    )
    return (
        f"<details{' open' if current in group.pages else ''}><summary>{escape(group.title)}</summary>\n"
        f"<ul>\n{items}</ul></details>\n"
    )


def sections(headings: Sequence[Heading]) -> str:
    """The headings of a page, where there are several."""
    shown = [one for one in headings if one.level in (2, 3)]
    if len(shown) < 2:
        return ""
    items = "".join(
        f'<li class="level-{one.level}"><a href="#{one.anchor}">{escape(one.text)}</a></li>\n' for one in shown
    )
    return f'<nav class="sections" aria-label="On this page"><p>On this page</p>\n<ul>\n{items}</ul></nav>\n'


def neighbours(current: Page, all_groups: Sequence[Group]) -> str:
    """The pages before and after, in the order of the index."""
    order = [one for group in all_groups for one in group.pages]
    if current not in order:
        return ""
    at = order.index(current)
    before = f'<a rel="prev" href="{order[at - 1].address}">← {escape(order[at - 1].title)}</a>' if at else ""
    after = order[at + 1 : at + 2]
    following = "".join(f'<a rel="next" href="{one.address}">{escape(one.title)} →</a>' for one in after)
    return f'<nav class="neighbours" aria-label="Neighbouring pages">{before}{following}</nav>\n'


def search(all_groups: Sequence[Group]) -> str:
    """The page of what a search found."""
    body = (
        f'<div class="frame">\n{contents(None, all_groups)}<main id="content" tabindex="-1">\n<h1>Search</h1>\n'
        '<p id="count" role="status">The search needs JavaScript.</p>\n<ol id="found"></ol>\n</main>\n</div>\n'
    )
    return document("Search · trueloop", body, "manual.js search-index.js search.js")
