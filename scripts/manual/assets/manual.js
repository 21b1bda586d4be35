"use strict";
// All pages are folded away where there is no room beside the text.
if (window.matchMedia("(max-width: 52rem)").matches) document.querySelector(".pages .all").open = false;

// "/" goes to the search, as on many sites.
document.addEventListener("keydown", (event) => {
  if (event.key !== "/" || event.ctrlKey || event.metaKey || /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName)) return;
  event.preventDefault();
  document.querySelector("header input").focus();
});

// What a button copies of a dialogue are its commands; of anything else all.
for (const figure of document.querySelectorAll("figure.console, figure.sh, figure.toml, figure.python, figure.csv")) {
  const commands = [...figure.querySelectorAll("pre b")].map((one) => one.textContent.trim());
  const text = figure.matches(".console") ? commands.join("\n") + "\n" : figure.querySelector("code").textContent;
  if (!navigator.clipboard || (figure.matches(".console") && !commands.length)) continue;
  const button = document.createElement("button");
  button.className = "copy";
  button.type = "button";
  button.textContent = "Copy";
  button.setAttribute("aria-label", `Copy: ${text.split("\n")[0]}`);
  button.addEventListener("click", async () => {
    await navigator.clipboard.writeText(text);
    button.textContent = "Copied";
  });
  figure.append(button);
}

// The section that is being read is marked in the list beside it.
const links = new Map([...document.querySelectorAll(".sections a")].map((one) => [decodeURIComponent(one.hash.slice(1)), one]));
const seen = new IntersectionObserver(
  (changes) => {
    for (const change of changes) {
      if (!change.isIntersecting) continue;
      for (const link of links.values()) link.removeAttribute("aria-current");
      links.get(change.target.id).setAttribute("aria-current", "true");
    }
  },
  { rootMargin: "0px 0px -70% 0px" },
);
for (const id of links.keys()) seen.observe(document.getElementById(id));
